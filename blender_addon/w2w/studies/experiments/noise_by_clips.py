# SPDX-License-Identifier: GPL-3.0-or-later
"""How the noise of F1 falls with the clips, where the truth is known: by half, or with p (1 - p) too?

    python -m w2w.studies.experiments.noise_by_clips [--draws 150]

Clips are drawn from known distributions (normal features about a mean an activity, shared within a clip),
and a linear discriminant is trained and tested by five folds on so many clips an activity and on twice as
many, again and again. Printed are the macro F1 at both sizes, and the variance of twice the clips by that
of so many: as it is found over the draws, by half, and as the share of so many clips that F1 is, p (1 - p)
over their number, by the activities' mean F1.
"""

from __future__ import annotations

import argparse

import numpy as np

from w2w.core.ranking.f1 import window_f1

WORLDS = ((4, 15), (11, 30))
"""Activities and features."""

APART = (0.25, 0.4, 0.6, 0.9)
"""Standard deviation of the activities' means, by that of clips."""

CLIPS = (3, 6, 12, 24)
"""Of each activity."""

WINDOWS, WITHIN = 2, 0.7
"""Windows a clip and their standard deviation about it."""

FOLDS, RIDGE = 5, 1.0


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--draws", type=int, default=150)
    draws = parser.parse_args().draws
    rng = np.random.default_rng(0)
    print("activities  apart   clips     F1            found   half   p (1 - p)")
    for activities, features in WORLDS:
        for apart in APART:
            strength = rng.uniform(0.3, 1.7, size=(activities, 1))
            means = rng.normal(size=(activities, features)) * apart * strength
            found = [np.array([drawn_f1(means, clips, rng) for _ in range(draws)]) for clips in CLIPS]
            for clips, few, many in zip(CLIPS, found, found[1:], strict=False):
                ratio = many.mean(axis=1).var() / few.mean(axis=1).var()
                shares = [of.mean(axis=0) for of in (many, few)]
                told = np.divide(*((p * (1 - p)).sum() for p in shares)) / 2
                said = (
                    f"{clips:2d}, {2 * clips:2d}   {few.mean():.3f}, {many.mean():.3f}   {ratio:5.2f}   0.50"
                )
                print(f"{activities:10d}  {apart:5.2f}  {said}   {told:9.2f}", flush=True)


def drawn_f1(means: np.ndarray, clips: int, rng: np.random.Generator) -> np.ndarray:
    """F1 of each activity, shape (A,), cross-validated on so many clips of each, drawn anew."""
    n_activities, n_features = means.shape
    of_clip = np.tile(np.arange(n_activities), clips)
    clip = means[of_clip] + rng.normal(size=(len(of_clip), n_features))
    labels = np.repeat(of_clip, WINDOWS)
    windows = np.repeat(clip, WINDOWS, axis=0)
    windows = windows + WITHIN * rng.normal(size=windows.shape)
    fold = np.repeat(np.arange(clips), n_activities * WINDOWS) % min(FOLDS, clips)
    named = np.empty(len(labels), dtype=int)
    for one in np.unique(fold):
        tested = fold == one
        named[tested] = discriminant(windows[~tested], labels[~tested], windows[tested])
    return window_f1(named, labels, n_activities)


def discriminant(train: np.ndarray, labels: np.ndarray, test: np.ndarray) -> np.ndarray:
    """What a linear discriminant with equal priors and a ridge names."""
    means = np.array([train[labels == one].mean(axis=0) for one in np.unique(labels)])
    about = train - means[labels]
    towards = np.linalg.solve(about.T @ about / len(about) + RIDGE * np.eye(train.shape[1]), means.T)
    return (test @ towards - (means.T * towards).sum(axis=0) / 2).argmax(axis=1)


if __name__ == "__main__":
    main()
