# SPDX-License-Identifier: GPL-3.0-or-later
"""How long choosing again takes under other wishes and weights, against the first choice in the same results.

    python -m benchmarks.choosing_again RESULTS

The panel and the web app choose so. Printed are seconds by the clock and of the processor: on a machine that
does other things as well, only the second say something.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from w2w.core.selection.constraints import Constraints
from w2w.core.study.choosing import Choices
from w2w.core.study.results import StudyResults

from .sets_speed import timed

WISHES = {
    "must right ankle": Constraints(must=("right ankle",)),
    "only both ankles": Constraints(only=("left ankle", "right ankle")),
    "must left wrist": Constraints(must=("left wrist",)),
    "forbid head": Constraints(forbid=("head",)),
    "no wish": Constraints(),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("results", type=Path)
    study = StudyResults.load(parser.parse_args().results)
    config = study.config()
    choices = Choices(study, config)
    first, _ = timed("the first choice", lambda: choices.under(config))
    asked = {name: replace(config, constraints=wishes) for name, wishes in WISHES.items()}
    asked["an activity as background"] = replace(config, background=study.utility.activities[:1])
    for name, by in asked.items():
        again, _ = timed(name, lambda by=by: choices.weighed(by).under(by))
        print(f"  {again / first:.2f} of the first's processor time")


if __name__ == "__main__":
    main()
