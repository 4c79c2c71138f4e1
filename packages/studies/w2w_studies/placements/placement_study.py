# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of the study of placements besides its tables: the paper's figure 4, verdicts on claims, a page."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console

from w2w.core.files import write_text
from w2w.core.selection.headline import doubt, mean_sentence
from w2w.core.study.results import StudyResults

from .activity_groups import PAPER_GROUPS
from .placement_patches import UNUSUAL, placement_patches
from .score_table import ScoreRow, score_table
from .trend_table import show_trends, trend_csv, trend_markdown
from .trends import Claim, judge

CLAIMS = Path(__file__).with_name("paper_claims.csv")
"""What the paper says of its groups of activities and of placements seldom used."""

PAGES = FIGURE, TRENDS, PAGE = "activities_by_placement.png", "trends.csv", "study.md"


def write_placement_study(
    study: StudyResults,
    group_of: Mapping[str, str],
    side: str,
    claims: Sequence[Claim],
    missing: Sequence[str],
    console: Console,
) -> None:
    """Print what the ranking says of the claims, and write figure, verdicts and page.

    `group_of`: group of each activity.
    `side` "left" or "right": of placements that are on both.
    `missing`: which activities were asked for and are not there, in sentences.
    """
    from .placement_figure import placement_figure  # matplotlib is slow to import

    out = study.out
    trends = judge(study.utility, study.patches, claims, group_of)
    show_trends(trends, console)
    found = placement_patches(study.body(), study.patches, side, lambda _: None)
    rows = figure_rows(study, group_of, [near.patch for near in found.values()])
    title = f"{len(rows)} activities at {len(found)} placements, {side} side"
    common = [name not in UNUSUAL for name in found]
    placement_figure(out / FIGURE, rows, list(found), common, title)
    write_text(out / TRENDS, trend_csv(trends))
    write_text(out / PAGE, _page(study, title, trend_markdown(trends), missing))
    console.print(f"Figure: {out / FIGURE}\nClaims: {out / TRENDS}\nPage:   {out / PAGE}")


def figure_rows(study: StudyResults, group_of: Mapping[str, str], patches: Sequence[int]) -> list[ScoreRow]:
    """The rows of the activities at some patches, group by group in the paper's order."""
    order = {group: number for number, group in enumerate(PAPER_GROUPS)}
    rows = [row for row in score_table(study.utility, patches, group_of) if row.activity]
    return sorted(rows, key=lambda row: (order.get(row.group, len(order)), row.group, row.activity))


def _page(study: StudyResults, title: str, trends: str, missing: Sequence[str]) -> str:
    """The study on a page of markdown."""
    utility = study.utility
    lines = [
        "# Activities by placement",
        "",
        f"{utility.protocol}; classifier {utility.classifier}; {len(study.clips)} clips.",
    ]
    sentences = [mean_sentence(utility), doubt(utility)]
    lines += [f"\n**{sentence}.**" for sentence in sentences if sentence]
    lines += [f"\n{sentence}" for sentence in missing]
    lines += ["", f"![{title}]({Path(FIGURE).name})", "", "## Claims", "", trends]
    return "\n".join(lines)
