# SPDX-License-Identifier: GPL-3.0-or-later
r"""How often an interval of rho between two rankings of a few sites holds the true rho.

    python -m w2w.studies.experiments.rho_intervals

Sites whose true scores are drawn anew in each of 500 trials, 8 people and 30 performers who depart from them,
and rho of the means with four intervals: percentile, bias-corrected, BCa (Efron 1987), and the one that
W2W states (`bootstrap_interval`). Printed: the share of intervals that hold the rho of the true scores.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import norm

from w2w.core.ranking.agreement import bootstrap_interval, spearman_rows

TRIALS, RESAMPLES, LEVEL = 500, 1000, 0.95
TAILS = np.array([(1 - LEVEL) / 2, (1 + LEVEL) / 2])


def main() -> None:
    """Print a table of sites and how far apart these are."""
    print("| sites | spread of sites over that of a person | percentile | bias-corrected | BCa | W2W |")
    print("|---|---|---|---|---|---|")
    for sites in (4, 5, 6, 8):
        for spread in (0.3, 0.6, 1.2):
            held = coverage(sites, spread, np.random.default_rng(0))
            print(f"| {sites} | {spread} | {' | '.join(f'{share:.2f}' for share in held)} |", flush=True)


def coverage(sites: int, spread: float, rng: np.random.Generator, trials: int = TRIALS) -> np.ndarray:
    """Share of trials in which each of the four intervals holds the true rho, shape (4,)."""
    held = np.zeros(4)
    for _ in range(trials):
        real, simulated = rng.normal(0, spread, (2, sites))
        simulated = (real + simulated) / np.sqrt(2)
        people = real + rng.normal(size=(8, sites))
        performers = simulated + rng.normal(size=(30, sites))
        truth = spearman_rows(real, simulated)
        bounds = np.array(intervals(people, performers, rng))
        held += (bounds[:, 0] <= truth + 1e-9) & (truth - 1e-9 <= bounds[:, 1])
    return held / trials


def intervals(people: np.ndarray, performers: np.ndarray, rng: np.random.Generator) -> list:
    """The four intervals of rho between the means of scores (N, S) and (M, S)."""
    sides = people, performers
    rho = float(spearman_rows(*(side.mean(axis=0) for side in sides)))
    draws = spearman_rows(*(_resampled(side, rng) for side in sides))
    below = ((draws < rho).mean() + (draws <= rho).mean()) / 2
    shift = norm.ppf(np.clip(below, 0.5 / RESAMPLES, 1 - 0.5 / RESAMPLES))
    moved = shift + norm.ppf(TAILS)
    bent = shift + moved / (1 - _acceleration(*sides) * moved)
    corrected = [np.quantile(draws, norm.cdf(at)) for at in (shift + moved, bent)]
    return [np.quantile(draws, TAILS), *corrected, bootstrap_interval(rho, draws, LEVEL)]


def _resampled(side: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    drawn = rng.multinomial(len(side), np.full(len(side), 1 / len(side)), size=RESAMPLES)
    return drawn @ side / len(side)


def _acceleration(people: np.ndarray, performers: np.ndarray) -> float:
    """BCa's, by leaving one out on either side."""
    means = [side.mean(axis=0) for side in (people, performers)]
    without = [(side.sum(axis=0) - side) / (len(side) - 1) for side in (people, performers)]
    left = spearman_rows(without[0], means[1]), spearman_rows(means[0], without[1])
    influence = np.concatenate([of.mean() - of for of in left])
    spread = (influence**2).sum() ** 1.5
    return float((influence**3).sum() / (6 * spread)) if spread else 0.0


if __name__ == "__main__":
    main()
