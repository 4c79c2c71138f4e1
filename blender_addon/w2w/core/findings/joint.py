# SPDX-License-Identifier: GPL-3.0-or-later
"""What the chosen sensors reach together: the result to trust, in figures and in a sentence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

ROUNDING = 1e-6


def joint_content(
    together: Sequence[dict[str, Any]], target: float, chosen: int, least: int = 1
) -> dict[str, Any] | None:
    """The smallest set whose joint classifier reaches the target, else the one that comes nearest.

    Parameters
    ----------
    together : sequence of dict
        What one classifier on the first sensor, the first two, and so on reached, and, where it is
        known, would reach on other clips.
    target : float
    chosen : int
        Sensors of the whole set, of which only the first few are tested together.
    least : int
        Fewest sensors that do what the designer asked for.

    Returns
    -------
    dict or None
        None where nothing was tested together.
    """
    tested = [entry for entry in together if entry["sensors"] >= least] or list(together[-1:])
    if not tested:
        return None
    reaching = [entry for entry in tested if entry["mean_f1"] >= target - ROUNDING]
    best = reaching[0] if reaching else max(tested, key=lambda entry: entry["mean_f1"])
    return {
        "sensors": best["sensors"],
        "expected_f1": best.get("expected_f1"),
        "expected_f1_interval": best.get("expected_f1_interval"),
        "mean_f1": best["mean_f1"],
        "mean_f1_interval": best["mean_f1_interval"],
        "target": target,
        "reached": bool(reaching),
        "sentence": _sentence(best, tested[-1], target, chosen, bool(reaching)),
    }


def sensors(count: int) -> str:
    """So many sensors, in words."""
    return f"{count} sensor{'' if count == 1 else 's'}"


def _sentence(best: dict[str, Any], last: dict[str, Any], target: float, chosen: int, reached: bool) -> str:
    score = f"F1 {best['mean_f1']:.3f} with {sensors(best['sensors'])}"
    if best.get("expected_f1") is not None:
        low, high = best["expected_f1_interval"]
        expected = f"expected F1 {best['expected_f1']:.3f} on other clips"
        interval = f"95 % interval {low:.2f} to {high:.2f}"
        lead = f"{expected} with {sensors(best['sensors'])} ({interval}); on these clips, "
    else:
        lead = ""
    if reached:
        return f"{lead}tested together, one classifier reaches {score} (target {target:.3g})"
    text = (
        f"{lead}tested together, up to {sensors(last['sensors'])} do not reach {target:.3g}: {score} at best"
    )
    if last["mean_f1"] < best["mean_f1"] - ROUNDING:
        text += f", {last['mean_f1']:.3f} with {last['sensors']}"
    return text + (f"; more than {last['sensors']} were not tested" if chosen > last["sensors"] else "")
