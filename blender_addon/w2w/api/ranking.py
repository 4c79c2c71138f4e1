# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W from Python: a ranking's scores, its best patch, sets to wear, a table, a picture and a report."""

from __future__ import annotations

import io
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from numbers import Integral
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.body.body import Body
from ..core.csv_tables import apart, csv_text
from ..core.files import write_text
from ..core.findings.cautions import Caution, cautions, heaviest_first, worn_cautions
from ..core.findings.new_folder import write_findings
from ..core.imu.recordings import Recordings
from ..core.library.library import Clip, Library
from ..core.patches.card import DROP
from ..core.patches.naming import resolve
from ..core.patches.own_placements import shown_on
from ..core.patches.patches import PatchSet
from ..core.ranking.pooling import Pooling
from ..core.ranking.stream import Stream
from ..core.ranking.turned import may_turn
from ..core.ranking.utility import UtilityMap
from ..core.selection.advice import Advice
from ..core.selection.answer import Answer, PlaceScore, ScoredMap, answer, compare
from ..core.selection.constraints import Constraints
from ..core.selection.headline import doubted, mean_title, short
from ..core.selection.joint import WornSet
from ..core.selection.set_tests import SetTests
from ..core.study.choosing import choose_to_wear, needed
from ..core.study.clip_files import WORK
from ..core.study.config import StudyConfig
from ..core.study.needs import Need
from ..core.study.ranking import LabelledClip, WindowLabels, set_tests
from ..core.study.results import ClipResult, Study, StudyResults
from ..core.windows.inputs import PatchBlocks
from ..core.windows.of_recordings import cut_recordings
from .notebook import Rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@dataclass(frozen=True, eq=False)
class Ranking:
    """How well each patch, or each place of worn sensors, alone recognises each activity, and what follows.

    Made by `w2w.rank` or, from what `w2w run` left in a folder, by `w2w.open_results`.

    Parameters
    ----------
    utility : UtilityMap
        F1 by patch and activity, with intervals, confusions and predictions.
    patches : PatchSet
    body : Body or None
        None for worn sensors, whose places are known by their names alone.
    inputs : ndarray or PatchBlocks, shape (W, N, ...)
        What the classifier trained on.
    labels : WindowLabels
        Labels of the W windows.
    config : StudyConfig
        Folds, windows and seed.
    classifier : str or object
    skipped : tuple of (str, str)
        Clips that took no part, each with the reason.
    clips : tuple of LabelledClip
        The ranked clips, each with the first that shows the same motion.
    details : sequence of dict
        Duration, windows and the like of each of them, for cautions and report.
    stream : Stream, optional
        The clips in a stream, by which sets are judged; None for other classifiers than the ridge.
    folder : Path, optional
        The results folder that it was read from, which holds all that a report says.
    recordings : Recordings, optional
        The recordings of worn sensors that it ranks, one after another as in `inputs`.

    Examples
    --------
    >>> ranking = w2w.open_results("RESULTS")
    >>> ranking.activities
    ('kicking', 'stirring', 'waving')
    >>> ranking.f1.shape
    (24, 3)
    """

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

    def __repr__(self) -> str:
        best = f"{self.names[self.best]}, F1 {self.expected[self.best]:.2f}"
        what = "patches" if self.recordings is None else "places"
        return f"<Ranking: {len(self.patches)} {what}, {len(self.activities)} activities; best: {best}>"

    def _repr_html_(self) -> str:
        """The display in a notebook: the answer and its cautions, the products, the body."""
        rows = [
            f"<tr><td>{escape(f'{score.side} {score.name}'.strip())}<td>{short(f1.mean)}"
            f"<td>{short(f1.low)} to {short(f1.high)}<td>{short(max(score.cost.expected, 0.0))}"
            f"<td>{short(score.cost.low)} to {short(score.cost.high)}<td>{score.cost.verdict()}"
            for score in self.answer.products
            for f1 in [score.in_stream or score.cut_out]
        ]
        about = self.answer.measured(), self.answer.lead()
        said = [*(f"{text}." for text in about if text), *(each.sentence() for each in self.cautions)]
        parts = [
            f"<p><b>{escape(self.answer.sentence())}</b></p>",
            *(f"<p>{escape(text)}</p>" for text in said),
            f"<table><tr><th>One sensor on<th>F1<th>95 % interval<th>Costs<th>95 % interval<th>"
            f"{''.join(rows)}"
            "</table>",
        ]
        if self.picture is not None:
            alt, source = escape(self.answer.sentence()), b64encode(self.picture).decode()
            parts.append(f'<img alt="{alt}" style="max-width: 100%" src="data:image/png;base64,{source}">')
        return "".join(parts)

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
        found = cautions(self.utility, self.clips, self.details, self.config)
        if self.recordings is not None:
            found += worn_cautions(self.clips, self.skipped, self.config.by_subject)
        return heaviest_first(found)

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
        return answer(self._scored)

    def compare(self, *words: str) -> tuple[PlaceScore, ...]:
        """Score products and places by name, such as "ring" and "left thigh front", best first.

        Raises
        ------
        ValueError
            If nothing is called one of them.
        """
        return compare(self._scored, words)

    def needs(self, place: str) -> Need:
        """Find how cheap a sensor on a product or at a place may be: rate, ranges, resolution, noise, window.

        A ridge is trained and tested again with each value, on signals made again from the motions. It takes
        seconds for tens of clips, minutes for hundreds.

        Parameters
        ----------
        place : str
            Such as "belt clip" or "left thigh front".

        Returns
        -------
        Need
            ``sentence()`` says it, "" where the clips tell nothing; ``losses`` holds the F1 and the cost of
            every value tried, ``parts`` real parts that do.

        Raises
        ------
        ValueError
            If the ranking was not read from a results folder, or nothing is called so.

        Examples
        --------
        >>> need = w2w.open_results("RESULTS").needs("belt clip")
        >>> need.place, need.own["rate"]
        ('left belt clip', 50.0)
        """
        if self.folder is None:
            raise ValueError("what a sensor needs is found from motions: write a results folder and open it")
        return needed(StudyResults.load(self.folder), [place])[0]

    @cached_property
    def _scored(self) -> ScoredMap:
        return ScoredMap(self.utility, self.patches, self.body, stream=self.stream)

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

    def wear_together(
        self,
        target: float = 0.9,
        every_activity: float = 0.0,
        max_sensors: int | None = None,
        constraints: Constraints | None = None,
    ) -> WornSet:
        """Choose patches by one classifier on all of them, with what they would reach on other clips.

        Parameters
        ----------
        target : float
            Expected macro F1 to reach in a stream of clips.
        every_activity : float
            Expected F1 to reach for each activity as well; 0 for no such limit.
        max_sensors : int, optional
        constraints : Constraints, optional
            Where sensors may and must go, and what they cost there.

        Returns
        -------
        WornSet
            ``order`` holds the patches, ``promise`` the expected F1 of the first, the first two, and so on,
            in a stream; ``cut_out`` has that on clips cut out.

        Raises
        ------
        ValueError
            If the constraints cannot be met, or the classifier is not the ridge.
        """
        if not isinstance(constraints, Constraints | None):
            raise ValueError(
                f"constraints must be Constraints, such as Constraints(forbid=('head',)), not {constraints!r}"
            )
        constraints = constraints or Constraints()
        wished: dict[str, Any] = {"target": target, "max_places": max_sensors}
        config = replace(self.config, **wished, every_activity=every_activity, constraints=constraints)
        constraints.terms(self.patches)  # refuse wrong ones before the slow part
        if self._set_tests is None:
            raise ValueError("only the classifier 'ridge' chooses sets to wear together")
        worn = choose_to_wear(
            self.utility, self.patches, self.body, config, self._set_tests, self.stream
        ).worn
        assert worn is not None  # sets were tested
        return worn

    @cached_property
    def _set_tests(self) -> SetTests | None:
        """Tests for sets of patches; None for other classifiers than the ridge."""
        pooling = Pooling.on(self.body, self.patches)
        return set_tests(self.inputs, self.labels, self.config, pooling, self.classifier, self.utility)

    @cached_property
    def advice(self) -> Advice:
        """The sensors recommended under no constraint, alone and together; `cards` says where each goes."""
        found = choose_to_wear(
            self.utility, self.patches, self.body, self.config, self._set_tests, self.stream
        )
        if self.recordings is None:
            return found
        protocol, rate = self.labels.protocol(self.config), self.recordings.rate
        cards = [
            replace(card, turn_deg=may_turn(self._worn_at(card.patch), rate, protocol, DROP))
            for card in found.cards
        ]
        return replace(found, cards=tuple(cards))

    def _worn_at(self, place: int) -> np.ndarray:
        """Windows of the sensor at a place, shape (W, samples, 6)."""
        assert self.recordings is not None
        cut = cut_recordings(
            self.recordings, self.config.windows, "windows", lambda windows: windows[:, place]
        )
        return np.concatenate(cut.inputs)

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
        chosen, utility = range(len(self.patches)) if patches is None else patches, self.utility
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
        write_text(Path(path), csv_text([list(rows[0]), *cells]))

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

        by_activity, mean = (self.utility.expected_f1, self.expected) if expected else (self.f1, self.mean)
        if activity is None:
            scores, title = mean, mean_title(self.utility)
        elif activity in self.activities:
            scores = by_activity[:, self.activities.index(activity)]
            title = activity.replace("_", " ").capitalize()
        else:
            raise ValueError(f"{activity!r} was not ranked; there are {', '.join(self.activities)}")
        best = self.best if expected and activity is None else int(np.argmax(scores))
        subtitle = doubted(self.utility, f"Best patch: {self.names[best]} ({scores[best]:.2f})")
        label = "Expected F1" if expected else "F1 on these clips"
        body, patches, scores = (
            (self.body, self.patches, scores) if self.body else shown_on(self.names, scores)
        )
        return draw_heatmap(
            path, body, patches, scores, title, subtitle, label, span=self.utility.colour_span
        )

    def report(self, path: str | Path) -> None:
        """Write the page that `w2w report` writes: the answer, the heatmaps in 3D, the choice, the tables.

        Parameters
        ----------
        path : str or Path
            One HTML file, which needs no network.

        Raises
        ------
        ValueError
            If the results folder that the ranking was read from is no longer whole.

        Examples
        --------
        >>> w2w.open_results("RESULTS").report("report.html")
        >>> Path("report.html").read_text(encoding="utf-8").strip()[:15]
        '<!doctype html>'
        """
        from ..report.page import report_page, worn_page  # jinja2 is slow to import

        if self.recordings is not None:
            cautions = [caution.sentence() for caution in self.cautions]
            said = {"cautions": cautions, "skipped": self.skipped, "names": self.names}
            page = worn_page(self.utility, self.advice, self.config, said, self.picture)
            write_text(Path(path), page)
            return
        with TemporaryDirectory(prefix="w2w_report_") as temporary:
            study = StudyResults.load(self.folder) if self.folder else self._written(Path(temporary))
            write_text(Path(path), report_page(study))

    def _written(self, out: Path) -> StudyResults:
        """The ranking and a choice of sensors, written into an empty folder as a run writes them."""
        assert self.body is not None
        (out / WORK).mkdir()
        results = StudyResults(out, self.utility, self.patches, self.clips, self.config.as_dict())
        used = tuple(
            Clip(Path(), about.get("file", clip.name), clip.name, clip.activity, clip.subject)
            for clip, about in zip(self.clips, self.details, strict=True)
        )
        library = Library(Path(), used, "Python", self.skipped)
        clips = tuple(
            ClipResult(clip, "", record, "") for clip, record in zip(used, self.details, strict=True)
        )
        write_findings(Study(library, self.config, self.body, clips, results, self.advice))
        return results
