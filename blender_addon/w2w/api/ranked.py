# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W from Python: a ranking's scores, its best place, a table and a picture."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.body.body import Body
from ..core.colours import Scale
from ..core.csv_tables import apart, csv_text
from ..core.files import write_text
from ..core.findings.cautions import Caution, cautions, heaviest_first, worn_cautions
from ..core.given import given_path
from ..core.imu.recordings import Recordings
from ..core.motion.motion import Motion
from ..core.patches.naming import resolve
from ..core.patches.own_placements import shown_on
from ..core.patches.patches import PatchSet
from ..core.ranking.stream import Stream
from ..core.ranking.utility import UtilityMap
from ..core.selection.answer import Answer, find_answer
from ..core.selection.headline import doubted, mean_title
from ..core.selection.scored import PlaceScore, ScoredMap, compare
from ..core.study.choosing import scored_map
from ..core.study.config import StudyConfig
from ..core.study.ranking import LabelledClip, WindowLabels
from ..core.windows.inputs import PatchBlocks
from ..core.wording import in_python
from .notebook import Rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@dataclass(frozen=True, eq=False)
class Ranked:
    """Scores of places, and what follows from them without a further ranking; see `Ranking`."""

    utility: UtilityMap
    patches: PatchSet
    body: Body | None
    inputs: np.ndarray | PatchBlocks
    labels: WindowLabels
    config: StudyConfig
    classifier: Any = "ridge"
    skipped: tuple[tuple[str, str], ...] = ()
    clips: tuple[LabelledClip, ...] = ()
    details: Sequence[dict[str, Any]] = ()
    stream: Stream | None = None
    folder: Path | None = None
    recordings: Recordings | None = None
    motions: tuple[Motion, ...] = ()

    def __repr__(self) -> str:
        best = f"{self.names[self.best]}, F1 {self.expected[self.best]:.2f}"
        what = "patches" if self.recordings is None else "places"
        return f"<Ranking: {len(self.patches)} {what}, {len(self.activities)} activities; best: {best}>"

    @cached_property
    def picture(self) -> bytes | None:
        """The heatmap of the mean as a PNG; None for places that W2W does not know."""
        stream = io.BytesIO()
        try:
            self.heatmap().savefig(stream, format="png")
        except ValueError:
            return None
        return stream.getvalue()

    @property
    def activities(self) -> tuple[str, ...]:
        """The activities tested, in the order of the columns of `f1`."""
        return self.utility.activities

    @property
    def left_out(self) -> dict[str, str]:
        """Activities of the clips that are not ranked, each with the reason."""
        return self.utility.left_out

    @cached_property
    def cautions(self) -> list[Caution]:
        """What speaks against the answer, as report, panel and console say it, the heaviest first."""
        patch = self.answer.patch
        found = cautions(self.utility, self.clips, self.details, self.config, patch=patch)
        if self.recordings is not None:
            found += worn_cautions(self.clips, self.skipped, self.config.by_subject)
        return [each._replace(text=in_python(each.text)) for each in heaviest_first(found)]

    @property
    def f1(self) -> np.ndarray:
        """F1 by patch and activity on these clips, shape (N, A); `utility.expected_f1` has that on others."""
        return self.utility.f1

    @property
    def mean(self) -> np.ndarray:
        """Macro F1 by patch on these clips, shape (N,)."""
        return self.utility.mean

    @property
    def expected(self) -> np.ndarray:
        """Macro F1 by patch that other clips would show, shape (N,); `best` and `heatmap` go by it."""
        return self.utility.expected_mean

    @cached_property
    def best(self) -> int:
        """The patch that would do best on other clips; `names[best]` is where it is."""
        return self._scored.best

    @cached_property
    def answer(self) -> Answer:
        """Where to wear one sensor, by `answer.sentence()`; `answer.products` are the alternatives."""
        return find_answer(self._scored)

    def compare(self, *words: str) -> tuple[PlaceScore, ...]:
        """Score products and places by name, such as "ring" and "left thigh front", best first.

        Raises
        ------
        ValueError
            If nothing is called one of them.
        """
        if not words or not all(isinstance(word, str) for word in words):
            raise ValueError("compare takes places by name, each for itself: compare('ring', 'left ankle')")
        return compare(self._scored, words)

    @cached_property
    def _scored(self) -> ScoredMap:
        return scored_map(self.utility, self.patches, self.body, self.config)

    @property
    def names(self) -> tuple[str, ...]:
        """A name for each patch, by its region."""
        return self.patches.names

    def at(self, *placements: str) -> list[int]:
        """Patches nearest to places by name, such as "wrist", "right ankle" or "left thigh front".

        Beyond 5 cm a warning says how far the patch is.

        Raises
        ------
        ValueError
            If there is no such place on the body, or no patch within 10 cm of it.
        """
        return [resolve(name, self.body, self.patches) for name in placements]

    def table(self, patches: Sequence[int] | None = None) -> Rows | DataFrame:
        """A row for each patch: number, name, region, expected F1 with its interval, F1 on these clips.

        A DataFrame where pandas is installed, else a list of dictionaries, which a notebook shows as a table.
        """
        rows = self._rows(patches)
        try:
            import pandas
        except ImportError:
            return rows
        return pandas.DataFrame(rows)

    def _rows(self, patches: Sequence[int] | None = None) -> Rows:
        utility = self.utility
        chosen = range(len(self.patches)) if patches is None else patches
        if isinstance(chosen, str) or not isinstance(chosen, Iterable):
            raise ValueError(
                f"table takes a list of patches, such as ranking.at('left wrist'), not {chosen!r}"
            )
        for patch in chosen:
            if not (isinstance(patch, Integral) and 0 <= patch < len(self.patches)):
                raise ValueError(
                    f"patches are numbered from 0 to {len(self.patches) - 1}, not {patch!r}; `at` finds them"
                )
        expected = ("expected_mean", "expected_low", "expected_high")
        after = ("mean", "mean_low", "mean_high")
        names = apart(self.activities, ("patch", "name", "region", *expected, *after))
        return Rows(
            {
                "patch": int(patch),
                "name": self.names[patch],
                "region": self.patches.regions[patch],
                **{name: float(getattr(utility, name)[patch]) for name in expected},
                **{name: float(value) for name, value in zip(names, utility.f1[patch], strict=True)},
                **{name: float(getattr(utility, name)[patch]) for name in after},
            }
            for patch in chosen
        )

    def to_csv(self, path: str | Path) -> None:
        """Write `table` as csv, whole or not at all."""
        rows = self._rows()
        cells = [
            [f"{value:.4f}" if isinstance(value, float) else value for value in row.values()] for row in rows
        ]
        write_text(given_path(path, "a csv"), csv_text([list(rows[0]), *cells]))

    def heatmap(
        self, path: str | Path | None = None, activity: str | None = None, expected: bool = True
    ) -> Figure:
        """Draw the expected F1 on the body, front and back.

        Parameters
        ----------
        path : str or Path, optional
            A PNG, SVG or PDF file to write.
        activity : str, optional
            One of `activities`; the mean over all by default.
        expected : bool
            F1 as other clips would show it; False for that on these clips.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ValueError
            If the activity was not ranked, or W2W knows a worn sensor's place by no name.
        """
        from ..drawing.heatmap import draw_heatmap

        path = path if path is None else given_path(path, "a picture")
        by_activity, mean = (self.utility.expected_f1, self.expected) if expected else (self.f1, self.mean)
        if activity is None:
            scores, title = mean, mean_title(self.utility)
        elif activity in self.activities:
            scores = by_activity[:, self.activities.index(activity)]
            title = activity.replace("_", " ").capitalize()
        else:
            raise ValueError(f"{activity!r} was not ranked; there are {', '.join(self.activities)}")
        best = int(np.argmax(scores))
        if expected and activity is None:
            best = self.best
        what = "patch" if self.recordings is None else "place"
        subtitle = doubted(self.utility, f"Best {what}: {self.names[best]} ({scores[best]:.2f})")
        label = "Expected F1" if expected else "F1 on these clips"
        scale = Scale.of(scores, title=label)
        body, patches, scores = (
            (self.body, self.patches, scores) if self.body else shown_on(self.names, scores)
        )
        return draw_heatmap(path, body, patches, scores, title, scale, subtitle)
