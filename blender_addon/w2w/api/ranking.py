# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W from Python: what to wear by a ranking, and the page that says it."""

from base64 import b64encode
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from numbers import Integral
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ..core.files import new_folder, write_text
from ..core.findings.cautions import below, head
from ..core.findings.new_folder import check_new, write_findings
from ..core.findings.notes import TOO_FEW
from ..core.findings.pilot import Pilot, RankedMap, pilot
from ..core.given import given_path
from ..core.imu.recordings import Recordings
from ..core.library.library import Clip, Library
from ..core.motion.signature import motion_signature
from ..core.patches.card import DROP
from ..core.ranking.pooling import Pooling
from ..core.selection.advice import Advice
from ..core.selection.constraints import Constraints
from ..core.selection.headline import short
from ..core.selection.joint import WornSet
from ..core.selection.set_tests import SetTests
from ..core.study.choosing import advise_under, find_needs, may_turn
from ..core.study.clip_files import WORK, features_file, motion_file, write_features
from ..core.study.needs import Need
from ..core.study.ranking import set_tests_of
from ..core.study.results import ClipResult, Study, StudyResults
from ..core.windows.inputs import cut_recordings
from .ranked import Ranked


@dataclass(frozen=True, eq=False, repr=False)
class Ranking(Ranked):
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
        The clips one after another, by which sets are judged; None for other classifiers than the ridge.
    folder : Path, optional
        The results folder that it was read from, which holds all that a report says.
    recordings : Recordings, optional
        The recordings of worn sensors that it ranks, one after another as in `inputs`.
    motions : tuple of Motion
        The motion of each clip, where the ranking is in memory.

    Examples
    --------
    >>> ranking = w2w.open_results("RESULTS")
    >>> ranking.activities
    ('kicking', 'stirring', 'waving')
    >>> ranking.f1.shape
    (24, 3)
    """

    def _repr_html_(self) -> str:
        """The display in a notebook: the answer and its cautions, the products, the body."""
        few = TOO_FEW if self.answer.caution else ""
        rows = [
            f"<tr><td>{escape(f'{score.side} {score.name}'.strip())}<td>{short(score.expected)}"
            f"<td>{few or f'{short(score.low)} to {short(score.high)}'}<td>{short(cost.expected)}"
            f"<td>{few or f'{short(cost.low)} to {short(cost.high)}'}<td>{cost.verdict()}"
            for score in self.answer.products
            for cost in [score.cost]
        ]
        about = self.answer.detail().removesuffix("."), self.answer.measured()
        said = [*(f"{text}." for text in about if text), *(each.sentence() for each in below(self.cautions))]
        on_top = head(self.answer.sentence(), self.cautions)
        parts = [
            f"<p><b>{escape(on_top)}</b></p>",
            *(f"<p>{escape(text)}</p>" for text in said),
            f"<table><tr><th>One sensor on<th>F1<th>95 % interval<th>Costs<th>95 % interval<th>"
            f"{''.join(rows)}"
            "</table>",
        ]
        if self.picture is not None:
            alt, source = escape(on_top), b64encode(self.picture).decode()
            parts.append(f'<img alt="{alt}" style="max-width: 100%" src="data:image/png;base64,{source}">')
        return "".join(parts)

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
            If the ranking is of worn sensors, or nothing is called so.

        Examples
        --------
        >>> need = w2w.open_results("RESULTS").needs("belt clip")
        >>> need.place, need.own["rate"]
        ('left belt clip', 50.0)
        """
        if self.recordings is not None:
            raise ValueError("what a sensor needs is found from motions, not from worn sensors")
        with TemporaryDirectory(prefix="w2w_needs_") as temporary:
            study = StudyResults.load(self.folder) if self.folder else self._written(Path(temporary))
            return find_needs(study, [place])[0]

    def with_recordings(self, recordings: Recordings) -> Pilot:
        """Hold recordings of people against the map: what they say of its level, everywhere.

        Parameters
        ----------
        recordings : Recordings
            Of places that W2W knows by name, of two people or more, in activities of the ranking.

        Returns
        -------
        Pilot
            ``sentence()`` says it beside the answer, ``next()`` what to record next; ``f1(score)`` is the F1
            at a place of `compare` with its 90 % interval, ``expected_f1`` that of every patch and activity.
            The order of places stays.

        Raises
        ------
        ValueError
            If W2W has no such place, the recordings say too little, or the ranking is of recordings itself.

        Examples
        --------
        >>> ranking = w2w.open_results("RESULTS")
        >>> labels = [(name, who) for name in ranking.activities for who in "abc" for _ in range(2)]
        >>> worn = [np.random.default_rng(n).normal([0, 0, 9.8, 0, 0, 0], size=(500, 6)) for n in range(18)]
        >>> recordings = w2w.Recordings.from_arrays({ranking.names[0]: worn}, 50, *zip(*labels))
        >>> ranking.with_recordings(recordings).people
        ('a', 'b', 'c')
        """
        if not isinstance(recordings, Recordings):
            raise ValueError(
                "with_recordings takes Recordings: w2w.Recordings.read('FOLDER', place='left wrist')"
            )
        return pilot(RankedMap(self._scored, self.config, self.inputs, self.labels), recordings)

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
            Expected macro F1 to reach where clips follow one another.
        every_activity : float
            Expected F1 to reach for each activity as well; 0 for no such limit.
        max_sensors : int, optional
        constraints : Constraints, optional
            Where sensors may and must go, and what they cost there.

        Returns
        -------
        WornSet
            ``order`` holds the patches, ``promise`` the expected F1 of the first, the first two, and so on.

        Raises
        ------
        ValueError
            If the constraints cannot be met, or the classifier is not the ridge.
        """
        if not isinstance(constraints, Constraints | None):
            raise ValueError(
                f"constraints must be Constraints, such as Constraints(forbid=('head',)), not {constraints!r}"
            )
        if max_sensors is not None and not (isinstance(max_sensors, Integral) and max_sensors >= 1):
            raise ValueError(f"max_sensors must be a whole number from 1 on, not {max_sensors!r}")
        constraints = constraints or Constraints()
        wished: dict[str, Any] = {"target": target, "max_places": max_sensors}
        config = replace(self.config, **wished, every_activity=every_activity, constraints=constraints)
        constraints.terms(self.patches)  # refuse wrong ones before the slow part
        if self._set_tests is None:
            raise ValueError("only the classifier 'ridge' chooses sets to wear together")
        worn = advise_under(self.utility, self.patches, self.body, config, self._set_tests, self.stream).worn
        assert worn is not None  # sets were tested
        return worn

    @cached_property
    def _set_tests(self) -> SetTests | None:
        """Tests for sets of patches; None for other classifiers than the ridge."""
        pooling = Pooling.on(self.body, self.patches)
        return set_tests_of(self.inputs, self.labels, self.config, pooling, self.classifier, self.utility)

    @cached_property
    def advice(self) -> Advice:
        """The sensors recommended under no constraint, alone and together; `cards` says where each goes."""
        found = advise_under(self.utility, self.patches, self.body, self.config, self._set_tests, self.stream)
        if self.recordings is None:
            return found
        planned, rate = self.labels.protocol(self.config).plan(halvings=0), self.recordings.rate
        cards = [
            replace(card, turn_deg=may_turn(self._worn_at(card.patch)[planned.used], rate, planned, DROP))
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

        path = given_path(path, "a report")
        if self.recordings is not None:
            cautions = [caution.sentence() for caution in below(self.cautions)]
            on_top = head(self.answer.sentence(), self.cautions)
            said = {"head": on_top, "cautions": cautions, "skipped": self.skipped, "names": self.names}
            page = worn_page(self.utility, self.advice, self.config, said, self.picture)
            write_text(path, page)
            return
        with TemporaryDirectory(prefix="w2w_report_") as temporary:
            study = StudyResults.load(self.folder) if self.folder else self._written(Path(temporary))
            write_text(path, report_page(study))

    def save(self, folder: str | Path) -> None:
        """Write a results folder, as `w2w run --no-signals` does, for commands, the panel and `stream`.

        Parameters
        ----------
        folder : str or Path
            A new or empty one.

        Raises
        ------
        ValueError
            If the folder is not empty, or the ranking has no motions: it was read from a folder, or worn.

        Examples
        --------
        >>> ranking.save("OUT")
        >>> w2w.open_results("OUT").activities == ranking.activities
        True
        """
        check_new(path := given_path(folder, "results"))
        if not self.motions:
            raise ValueError(
                "only a ranking of motions in memory is saved: others lie in a folder or are worn"
            )
        with new_folder(path) as out:
            self._written(out)

    def _written(self, out: Path) -> StudyResults:
        """The ranking and a choice of sensors, written into an empty folder as a run writes them."""
        assert self.body is not None
        for name in ("motions", f"{WORK}/features"):
            (out / name).mkdir(parents=True)
        first = 0
        for clip, motion, about in zip(self.clips, self.motions, self.details, strict=False):
            some = slice(first, first := first + about["windows"])
            motion.labelled(clip.activity, clip.subject, clip.name).save(motion_file(out, clip.name))
            known = self.labels.is_test[some], motion_signature(motion)
            write_features(features_file(out, clip.name), np.asarray(self.inputs)[some], *known)
        results = StudyResults(out, self.patches, self.clips, self.config.as_dict(), self.utility)
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
