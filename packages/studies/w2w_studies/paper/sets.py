# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's sets of a finished study: algorithm 2's, the exact optimum, their promises, the joint test."""

from dataclasses import dataclass
from typing import Any

from w2w.core.files import DIGITS
from w2w.core.findings.advice_content import expected_content, patch_content
from w2w.core.ranking.utility import UtilityMap
from w2w.core.selection.constraints import fewest
from w2w.core.study.choosing import set_tests_in
from w2w.core.study.config import StudyConfig
from w2w.core.study.results import StudyResults
from w2w.core.wording import count

from .joint_test import joint_content, sensors_together, together_content
from .promised import LargePromises, exact_by_half, greedy_by_half, promised
from .subsets import ROUNDING, Subset, counted_columns, exact_subset, greedy_subset


@dataclass(frozen=True, eq=False)
class PaperSets:
    """The sets that the paper's proxy chooses."""

    greedy: Subset  # by algorithm 2
    exact: Subset | None  # the cheapest set that does it; None if the solver found none in time
    together: list[UtilityMap]
    """What one classifier on the first sensor of `greedy`, the first two, and so on reaches on these
    clips."""
    least: int  # how many of its first patches it takes to have one wherever one must be

    def joint(self) -> dict[str, Any] | None:
        """What the smallest set that is enough reaches when it is tested as one."""
        tested = together_content(self.together, self.greedy.promise)
        return joint_content(tested, self.greedy.target, len(self.greedy.order), self.least)

    def gap_sentence(self) -> str:
        """Say how far the greedy set is from the optimum."""
        if self.exact is None:
            return "the exact optimum was not found in time"
        greedy, exact = self.greedy, self.exact
        proof = "" if exact.proven else " (the best found in the time allowed, not proven)"
        score = f"{exact.mean_max_after_each[-1]:.3f} with {_sensors(exact)}"
        if exact.reached and not greedy.reached:
            return f"the exact optimum reaches the target, {score}{proof}"
        if exact.cost < greedy.cost - ROUNDING:
            return f"the exact optimum reaches {score}, greedy needs {_sensors(greedy)}{proof}"
        gain = exact.mean_max_after_each[-1] - greedy.mean_max_after_each[-1]
        if gain > ROUNDING:
            return f"the exact optimum reaches {score}, {gain:.3f} more than greedy{proof}"
        return f"greedy is as good as the exact optimum{proof}"


def paper_sets(study: StudyResults, config: StudyConfig) -> PaperSets:
    """Choose the paper's sets from a finished ranking, and test them.

    Raises ValueError if the constraints cannot be met.
    """
    utility, terms = study.utility, config.constraints.terms(study.patches, config.max_places)
    asked = (
        counted_columns(utility.f1, utility.weights),
        config.target,
        terms.max_size,
        terms.allowed,
        terms.required,
        terms.price,
    )
    greedy = greedy_subset(*asked)
    try:
        exact = exact_subset(*asked)
    except TimeoutError:
        exact = None
    tests = set_tests_in(study, config)
    if tests is not None:
        promises = LargePromises(tests, terms)
        greedy = promised(greedy, promises, utility.expected, greedy_by_half)
        if exact is not None:
            exact = promised(exact, promises, utility.expected, exact_by_half)
    together = sensors_together(study, greedy.order)
    return PaperSets(greedy, exact, together, fewest(greedy.order, terms.required))


def sets_content(sets: PaperSets, study: StudyResults) -> dict[str, Any]:
    """The sets as plain values."""
    exact = sets.exact
    return {
        "subset": subset_content(sets.greedy, study),
        "exact": None if exact is None else {**subset_content(exact, study), "proven": exact.proven},
        "greedy_and_exact": sets.gap_sentence(),
        "together": together_content(sets.together, sets.greedy.promise),
        "joint": sets.joint(),
    }


def subset_content(subset: Subset, study: StudyResults) -> dict[str, Any]:
    """A set of sensors with what it would reach on other clips, and its reach by the proxy on these."""
    made, reached = subset.promise, subset.mean_max_after_each
    return {
        "target": subset.target,
        "reached": subset.reached,
        "sentence": subset.proxy_sentence(),
        "expected_sentence": subset.expected_sentence(),
        "best_reachable": round(subset.best_reachable, DIGITS),
        "cost": subset.cost,
        "places": [
            {
                **patch_content(patch, study.utility, study.patches),
                **({} if made is None else expected_content(made, number, "_so_far")),
                "mean_max_f1_so_far": round(value, DIGITS),
            }
            for number, (patch, value) in enumerate(zip(subset.order, reached, strict=True), start=1)
        ],
    }


def _sensors(subset: Subset) -> str:
    text, number = count("sensor", len(subset.order)), len(subset.order)
    return text if abs(subset.cost - number) < ROUNDING else f"{text} at a cost of {subset.cost:g}"
