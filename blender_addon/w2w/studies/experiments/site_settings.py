# SPDX-License-Identifier: GPL-3.0-or-later
"""What another ridge or fewer features do to the site that simulation calls best, on sets seen before.

Run as `python -m w2w.studies.experiments.site_settings LIBRARY... --upfall UP-FALL --mhad acc.npz`.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer

from w2w.core.ranking.agreement import bootstrap_interval
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.windows.features import feature_names

from ..comparisons.truth import DATA_SETS
from ..comparisons.unpaired import Sides, unpaired_sides
from ..validation.regret import lost
from ..validation.sites import SiteValidation, validate_sites


class Setting(NamedTuple):
    """A ridge, and which features, by their names, it takes."""

    ridge: Any = Ridge.name
    takes: Callable[[str], bool] = lambda _: True


SETTINGS: Mapping[str, Setting] = {
    "as W2W is": Setting(),
    **{f"ridge {alpha:g}": Setting(Ridge(alphas=(alpha,))) for alpha in (0.1, 0.3, 1.0, 3.0)},
    "no amplitudes": Setting(takes=lambda name: "|" not in name),
    "no means of the accelerometer": Setting(
        takes=lambda name: name not in {f"acc {axis} mean" for axis in "xyz"}
    ),
}


def compared(sides: Sides, setting: Setting, samples: int, rate: float) -> SiteValidation:
    """Both sides of an analysis, ranked under a setting."""
    kept = [setting.takes(name) for name in feature_names(samples, rate)]
    real, made = (
        side.windows._replace(features=side.windows.features[..., kept])
        for side in (sides.real, sides.simulated)
    )
    return validate_sites(
        real, made, sides.sites, sides.activities, by_subject=(True, True), site_of=sides.site_of,
        classifier=setting.ridge,
    )  # fmt: skip


def drawn_regrets(found: SiteValidation) -> np.ndarray:
    """F1 that people lose at the site that simulation calls best, in each resample of people and clips."""
    return lost(found.real.mean_samples[..., None], found.simulated.mean_samples[..., None])


def best(found: SiteValidation) -> str:
    """The best site of simulation, and of people."""
    return " and ".join(found.sites[int(side.mean.argmax())] for side in (found.simulated, found.real))


def main(
    libraries: list[Path],
    upfall: Annotated[Path | None, typer.Option()] = None,
    mhad: Annotated[Path | None, typer.Option()] = None,
    umafall: Annotated[Path | None, typer.Option()] = None,
    dsads: Annotated[Path | None, typer.Option()] = None,
) -> None:
    """Print, for each data set and setting, rho, regret, and how much more is lost than as W2W is."""
    given = {"upfall": upfall, "mhad": mhad, "umafall": umafall, "dsads": dsads}
    heads = (
        "data set",
        "setting",
        "rho",
        "mean rho",
        "best simulated and worn",
        "regret",
        "more than as W2W is",
    )
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for name, path in given.items():
        if path is None:
            continue
        protocol = DATA_SETS[name]
        sides = unpaired_sides(protocol, protocol.read(path), libraries, 0, lambda _: None)(
            protocol.analyses[0]
        )
        assert sides is not None
        samples = round(protocol.windows.length_s * protocol.rate_hz)
        first = None
        for setting, how in SETTINGS.items():
            found = compared(sides, how, samples, protocol.rate_hz)
            first = first or found
            more = found.regret.lost - first.regret.lost
            low, high = bootstrap_interval(more, drawn_regrets(found) - drawn_regrets(first))
            rho = f"{found.overall.spearman:.2f} | {found.mean_rho:.2f}"
            print(
                f"| {protocol.name} | {setting} | {rho} | {best(found)} | {found.regret.lost:.3f} "
                f"| {more:.3f} ({low:.3f} to {high:.3f}) |",
                flush=True,
            )


if __name__ == "__main__":
    typer.run(main)
