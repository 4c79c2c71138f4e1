# SPDX-License-Identifier: GPL-3.0-or-later
"""A designer's constraints, in words, and the terms of a choice among patches that follow from them."""

from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from ..csv_tables import read_table
from ..parameters import parameter
from ..patches.body_parts import find_patches
from ..patches.patches import PatchSet


@dataclass(frozen=True, eq=False)
class Terms:
    """Terms of a choice among N patches."""

    allowed: np.ndarray  # (N,), bool
    required: list[np.ndarray]  # numbers of patches; one of each array must be chosen
    price: np.ndarray  # (N,), positive
    max_size: int
    rarity: np.ndarray | None = None  # (N,): of patches that do alike, the lowest is taken
    unwished: "Terms | None" = None  # the terms if nothing were wished; None if nothing is


WISH: dict[str, Any] = {"stage": "choice", "web": True}


@dataclass(frozen=True)
class Constraints:
    """A designer's wishes, in words (see `body_parts.find_patches`).

    Parameters
    ----------
    only : tuple of str
        The only regions to take patches from; empty for everywhere.
    forbid : tuple of str
        Regions not to take patches from.
    must : tuple of str
        Regions to take at least one patch from, each.
    costs : tuple of (str, float)
        Price or discomfort of a sensor there, positive; 1 elsewhere. The last match
        wins.

    Raises
    ------
    ValueError
        If a wish is no list of words, or a cost is not positive.

    Examples
    --------
    >>> w2w.Constraints(forbid=("head", "hand"), costs=(("wrist", 0.5),)).forbid
    ('head', 'hand')
    """

    only: tuple[str, ...] = parameter(
        (),
        "Use only these regions, comma-separated: 'left', 'left,middle', 'arm,torso', 'left wrist'.",
        **WISH,
    )
    forbid: tuple[str, ...] = parameter((), "Never use these regions: 'head,hand,foot'.", **WISH)
    must: tuple[str, ...] = parameter(
        (), "Use at least one patch in each of these regions: 'left wrist'.", **WISH
    )
    costs: tuple[tuple[str, float], ...] = parameter(
        (),
        "csv with columns region, cost: price or discomfort of a sensor there (1 elsewhere).",
        group="Design constraints", stage="choice",
    )  # fmt: skip

    def __post_init__(self) -> None:
        for name in ("only", "forbid", "must"):
            words = getattr(self, name)
            if not isinstance(words, list | tuple) or not all(isinstance(word, str) for word in words):
                raise ValueError(f"{name} is a list of words, such as ('head', 'left wrist'), not {words!r}")
        pairs = isinstance(self.costs, list | tuple) and all(len(pair) == 2 for pair in self.costs)
        if not pairs or not all(isinstance(cost, Real) for _, cost in self.costs):
            raise ValueError(f"costs are pairs such as ('leg', 2.0), not {self.costs!r}")
        for words, cost in self.costs:
            if not (np.isfinite(cost) and cost > 0):
                raise ValueError(f"the cost of {words!r} must be a positive number, not {cost}")

    def terms(self, patches: PatchSet, max_size: int | None = None) -> Terms:
        """The terms of a choice of at most `max_size` patches, by default of any number.

        Raises
        ------
        ValueError
            If words mean no patch, nothing may be chosen, a patch that must be may not, or more must be
            chosen than `max_size`.
        """
        allowed = np.ones(len(patches), dtype=bool)
        if self.only:
            allowed[:] = False
            allowed[self._patches(patches, self.only)] = True
        allowed[self._patches(patches, self.forbid)] = False
        if not allowed.any():
            where = f"only {', '.join(self.only)}" if self.only else "the body"
            without = f", without {', '.join(self.forbid)}" if self.forbid else ""
            why = without or f", where none of the {len(patches)} patches lies: use more"
            raise ValueError(f"nothing is left to choose from: {where}{why}")
        price_of = np.ones(len(patches))
        for words, price in self.costs:
            price_of[self._patches(patches, [words])] = price
        required = [self._patches(patches, [words]) for words in self.must]
        for words, options in zip(self.must, required, strict=True):
            if not len(options):
                raise ValueError(
                    f"{words!r} must be chosen, but none of the {len(patches)} patches lies there: use more"
                )
            if not allowed[options].any():
                raise ValueError(f"{words!r} must be chosen, but no patch there is allowed")
        limit = int(allowed.sum()) if max_size is None else max_size
        if limit < max(1, len(required)):
            raise ValueError(f"max_size is {limit}, but {max(1, len(required))} patches are required")
        return Terms(allowed, [options[allowed[options]] for options in required], price_of, limit)

    @staticmethod
    def _patches(patches: PatchSet, wishes: Sequence[str]) -> np.ndarray:
        matches = [find_patches(patches.regions, patches.names, words) for words in wishes]
        return np.concatenate([np.empty(0, dtype=int), *matches])


def read_costs(path: str | Path) -> tuple[tuple[str, float], ...]:
    """Read costs from a csv file with columns ``region``, ``cost``; a ValueError says which line is bad."""
    costs = []
    for line, row in read_table(path, ("region", "cost")).rows:
        try:
            costs.append((row["region"], float(row["cost"])))
        except ValueError:
            raise ValueError(f"{path}, line {line}: '{row['cost']}' is no number") from None
    return tuple(costs)


def fewest(order: Sequence[int], required: Sequence[np.ndarray]) -> int:
    """How many of the first patches chosen it takes to have one of each required."""
    chosen = np.array(order)
    places = [np.flatnonzero(np.isin(chosen, options)) for options in required]
    return max((int(place[0]) + 1 for place in places if len(place)), default=1)
