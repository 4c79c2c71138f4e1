# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions that a body can make: cuts rest poses and damage off the ends and refuses what is impossible."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from ..body.body import BODY_HANDS, JOINT_INDEX, JOINT_NAMES, N_JOINTS, Body
from ..rotations import length
from .motion import Motion
from .skinning import joint_transforms, on_the_ground
from .source import UnusableMotion, refuse_few_frames, refuse_still

FASTEST_PELVIS = 12.4
"""m/s. Usain Bolt ran 20 m in 1.61 s in Berlin on 16 August 2009, and reached 12.14 m/s over 20 m in Zagreb
(Čoh et al. 2018, doi:10.26582/k.50.2.10). Nobody was measured faster."""

FASTEST_JOINT = 47.0
"""m/s. The fastest pitch was 105.8 miles an hour (Aroldis Chapman, 24 September 2010): no hand is faster than
the ball that leaves it, and no other joint is faster than a pitcher's hand."""

LONGEST_CUT_S = 0.25
"""Damage at either end is cut off up to this length, and up to a quarter of the frames."""

JUMP = 4.0
"""A step this many times as far as any other in the clip leads from or to a pose that is not part of it."""

NEAR_S = 0.1
"""A step from or to the skeleton's rest pose is only compared with those in this time next to it."""

SMALLEST_JUMP = 0.02
STILL = 2e-5
"""Steps below `SMALLEST_JUMP`, in skeleton sizes, are no jumps; those below `STILL` are no movement."""

REST_POSE = "a rest pose"

RESTING = np.cos(np.radians(20))
"""Largest turn of a joint from the rest pose in a frame that shows it."""

OPPOSED, CLOSELY, BENT = 0.5, 0.8, 0.9
"""A path shows its unit if a foot that the body stands on moves against it (cosine of their steps at least
`OPPOSED`), or it sinks as the body bends or lies down (correlation at least `BENT`)."""

NEAR, WIDE = (0.55, 2.2), (0.2, 5.0)
"""Factors by which a path in the right unit exceeds the legs' way: `NEAR` if the feet move against it
`CLOSELY`, else `WIDE`, as feet that slide or leave the ground carry a body further."""

STOOD_ON = 0.1
"""Metres that a foot which the body stands on is above its lowest joint at most."""

LEAST_BEND = 0.1
"""Metres between pelvis and lowest joint that come and go as a body bends."""

MENDED = 5
"""Frames of which the middle place counts where joints are not smoothed yet: two that jump are outliers."""

OFTEN = 10
"""A motion too fast at one in this many steps is in another unit or at another frame rate."""

UNITS = (
    (2.54, "centimetres", "inches"),
    (3.28, "feet", "metres"),
    (10, "millimetres", "centimetres"),
    (12, "inches", "feet"),
    (30.48, "centimetres", "feet"),
    (39.37, "inches", "metres"),
    (100, "centimetres", "metres"),
    (1000, "millimetres", "metres"),
)
"""How many of one unit another has."""

ALIKE = 1.5
"""Units are distinguished if their lengths differ by more."""

FEET = [JOINT_INDEX["left_foot"], JOINT_INDEX["right_foot"]]
BODY = slice(0, min(BODY_HANDS))


class BelievableMotion(NamedTuple):
    """The part of a motion that a body can make."""

    motion: Motion
    cut: str  # which frames at the ends were cut off and why, in words; "" if none


def believed(
    body: Body,
    motion: Motion,
    rest: np.ndarray | None = None,
    first_frame: int = 0,
    cut: str = "",
    path: np.ndarray | None = None,
    path_apart: bool = True,
) -> BelievableMotion:
    """The motion without rest poses and damage at its ends.

    `rest` (24, 3, 3) are the joints' world rotations in the skeleton's rest pose, by default the T-pose's;
    `first_frame` is the number of the first frame in the file, and `cut` is what was cut off before, in
    words. `path` (T, 3) is the pelvis's as the file has it, by default the motion's; if it is not
    `path_apart` from the joints, both are in one unit.

    Raises UnusableMotion, with frame, speed and likely unit, if the rest still moves faster than a body, or
    does not move.
    """
    turned, heads = joint_transforms(body, motion)
    part = moving_part(heads, lambda frames: _rests(turned[frames], rest), motion.rate)
    cut = cut_words(part, len(heads), REST_POSE, first_frame, cut)
    if path_apart:
        path = heads[:, 0] if path is None else path
        _refuse_unit(heads[part], path[part], motion.rate, first_frame + part.start)
    kept, cut = _undamaged(heads, part, motion.rate, first_frame, cut, path_apart)
    refuse_few_frames(kept.stop - kept.start, " of motion" if cut else "")
    refuse_still(heads[kept], turned[kept, :, :, 1])
    if kept == slice(0, len(heads)):
        return BelievableMotion(motion, cut)
    motion = replace(motion, rotations=motion.rotations[kept], pelvis=motion.pelvis[kept])
    return BelievableMotion(on_the_ground(body, motion), cut)


def unbroken(body: Body, motion: Motion) -> tuple[slice, str]:
    """The frames of a motion of joints as they were seen, less rest poses and damage at its ends, in words.

    Smoothing would hide a jump of the whole body, which is refused; it mends that of a limb, or of a frame.
    """
    turned, heads = joint_transforms(body, motion)
    part = moving_part(heads, lambda frames: _rests(turned[frames], None), motion.rate)
    place = median_filter(heads[:, :1], (MENDED, 1, 1), mode="nearest")
    cut = cut_words(part, len(heads), REST_POSE)
    return _undamaged(place, part, motion.rate, 0, cut, path_apart=False)


def _rests(turned: np.ndarray, rest: np.ndarray | None) -> np.ndarray:
    """The frames, shape (T,), of world rotations (T, 24, 3, 3) that show the skeleton's rest pose."""
    return shows_rest(
        turned[:, BODY], np.tile(np.eye(3), (N_JOINTS, 1, 1))[BODY] if rest is None else rest[BODY]
    )


def shows_rest(turned: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """The frames, shape (T,), in which joints (T, J, 3, 3) stand to the first as in a rest pose (J, 3, 3)."""
    with_first = np.tensordot(turned[:, 0] @ rest[0].T, rest, (2, 1))  # (T, 3, J, 3)
    cosine = (np.einsum("tjab,tajb->tj", turned, with_first) - 1) / 2
    return cosine.min(axis=1) > RESTING


def moving_part(heads: np.ndarray, resting: Callable[[list[int]], np.ndarray], rate: float) -> slice:
    """The frames of joints (T, J, 3) between rest poses at the start and at the end.

    A pose there, of one frame or held, is not part of the motion if the step from it or to it is a jump.
    `resting` says which of some frames show the skeleton's rest pose.
    """
    by_joint = np.ascontiguousarray(heads.transpose(1, 2, 0))  # ten times as fast
    size = float(np.median(np.ptp(by_joint, axis=0).max(axis=0))) or 1.0
    steps = length(np.diff(heads, axis=0)).max(axis=1) / size
    near = max(3, round(NEAR_S * rate))
    moving = np.flatnonzero(steps > STILL)
    if len(moving) == 0:
        return slice(0, len(heads))
    first, last = int(moving[0]), int(moving[-1])
    rests_first, rests_last = resting([first, last + 1])
    jumps_in = _jumps(steps[first : max(last, first + 1)], rests_first, near)
    jumps_out = _jumps(steps[first + 1 : last + 1][::-1], rests_last, near)
    start = first + jumps_in if jumps_in else 0
    stop = last + 2 - jumps_out if jumps_out else len(heads)
    return slice(start, stop) if start < stop else slice(0, len(heads))


def _jumps(steps: np.ndarray, resting: bool, near: int) -> int:
    """Number of steps that lead out of a pose: 0 if it belongs to the motion, 2 with a frame between."""
    for count in (1, 2) if resting else (1,):
        jump, others = steps[:count], steps[count : count + near] if resting else steps[count:]
        if len(jump) == count and jump.min() > max(JUMP * others.max(initial=0.0), SMALLEST_JUMP):
            return count
    return 0


def _speeds(heads: np.ndarray, rate: float) -> np.ndarray:
    """Speed (T - 1, J) of joints (T, J, 3) between frames, m/s."""
    return length(np.diff(heads, axis=0)) * rate


def _undamaged(
    heads: np.ndarray, part: slice, rate: float, first_frame: int, cut: str, path_apart: bool
) -> tuple[slice, str]:
    """The frames of a part between those near its ends at which a body would be too fast; adds to `cut`."""
    heads, first_frame = heads[part], first_frame + part.start
    n_frames, speeds = len(heads), _speeds(heads, rate)
    bad = np.flatnonzero((speeds[:, 0] > FASTEST_PELVIS) | (speeds.max(axis=1) > FASTEST_JOINT))
    most = min(round(LONGEST_CUT_S * rate), n_frames // 4)
    early, late = bad[bad < most], bad[bad >= n_frames - 1 - most]
    start, stop = (early[-1] + 1 if len(early) else 0), (late[0] + 1 if len(late) else n_frames)
    if len(bad) > len(early) + len(late):
        raise UnusableMotion(f"{_fastest(speeds, first_frame)}: {_advice(heads, bad, rate, path_apart)}")
    why = f"damaged (up to {speeds.max(initial=0.0):,.0f} m/s)"
    cut = cut_words(slice(start, stop), n_frames, why, first_frame, cut)
    return slice(int(part.start + start), int(part.start + stop)), cut


def _fastest(speeds: np.ndarray, first_frame: int) -> str:
    """Which joint is too fast, where and by which limit, in words."""
    over = speeds / FASTEST_JOINT
    over[:, 0] = speeds[:, 0] / FASTEST_PELVIS
    joint = 0 if over[:, 0].max() > 1 else int(over.max(axis=0).argmax())
    step = int(over[:, joint].argmax())
    frame, name = first_frame + step, JOINT_NAMES[joint].replace("_", " ")
    limit = f"a pitcher's hand ({FASTEST_JOINT:g} m/s)" if joint else f"a sprinter ({FASTEST_PELVIS:g} m/s)"
    at = f"{speeds[step, joint]:,.0f} m/s between frames {frame} and {frame + 1}"
    return f"its {name} moves at {at}, faster than {limit}"


def _advice(heads: np.ndarray, bad: np.ndarray, rate: float, path_apart: bool) -> str:
    """Advice on a motion that is too fast at some steps, though its legs suggest no other unit."""
    if OFTEN * len(bad) <= len(heads):
        wrong = "unit or frame rate" if path_apart else "frame rate"
        return f"it jumps there: cut it there, or correct its {wrong}"
    if not path_apart:
        return f"it jumps there, or its frame rate, {rate:g}, is too high: cut it there, or give --pose-rate"
    travels = _speeds(heads[:, :1], rate) > FASTEST_PELVIS
    if times_too_far(heads, heads[:, 0])[0] or OFTEN * np.count_nonzero(travels) <= len(heads):
        return (
            f"its frame rate, {rate:g}, looks too high: give --pose-rate, or Frame Rate in Blender's import "
            "dialog"
        )
    return f"{_unit_advice(100)} (if they are millimetres, by 1000)"


def _refuse_unit(heads: np.ndarray, path: np.ndarray, rate: float, first_frame: int) -> None:
    """Refuse a motion whose pelvis travels in another unit than the body."""
    factor, (least, most) = times_too_far(heads, path)
    if not factor or least <= factor <= most:
        return
    if factor < 1:
        travel = np.ptp(path, axis=0).max()
        raise UnusableMotion(
            f"its pelvis moves by {travel:.2g} m, where its legs walk or bend: {_unit_advice(factor)}"
        )
    speeds = _speeds(path[:, None], rate)[:, 0]
    step = int(speeds.argmax())
    raise UnusableMotion(
        f"its pelvis moves at {speeds[step]:,.3g} m/s between frames {first_frame + step} and "
        f"{first_frame + step + 1}, and its legs do not follow: {_unit_advice(factor)}"
    )


def _unit_advice(factor: float) -> str:
    """A sentence on the likely units of a travel that is too large by a factor, and what to do."""
    apart = {unit: abs(abs(np.log(factor)) - np.log(unit[0])) for unit in UNITS}
    likely = [unit for unit in UNITS if apart[unit] < np.log(ALIKE)] or [min(UNITS, key=apart.__getitem__)]
    names = [f"{small}, not {large}" if factor > 1 else f"{large}, not {small}" for _, small, large in likely]
    do = "divide" if factor > 1 else "multiply"
    times = " or ".join(f"{times:g}" for times, *_ in likely)
    return f"its translation looks like {', or '.join(names)}: {do} it by {times}"


def times_too_far(heads: np.ndarray, path: np.ndarray) -> tuple[float, tuple[float, float]]:
    """Factor by which a path (T, 3) exceeds the legs' way, and the range of a body's.

    The first is 0 if the legs do not show it.
    """
    feet, lowest = heads[:, FEET] - heads[:, :1], (heads[:, :, 2] - heads[:, :1, 2]).min(axis=1)
    lower = feet[:-1, :, 2].argmin(axis=1)[:, None, None]
    foot = np.take_along_axis(np.diff(feet, axis=0), lower, axis=1)[:, 0]
    steps = np.diff(path, axis=0)
    length = np.linalg.norm(steps, axis=1)
    stands = (feet[:-1, :, 2].min(axis=1) < lowest[:-1] + STOOD_ON) & (length <= 10 * np.median(length))
    cosine, factor = _against(steps[stands], foot[stands])
    if cosine > OPPOSED:
        return factor, NEAR if cosine > CLOSELY else WIDE
    height = path[:, 2]
    cosine, factor = _against(height - height.mean(), lowest - lowest.mean())
    return factor if cosine > BENT and np.ptp(lowest) > LEAST_BEND else 0.0, WIDE


def _against(path: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """Cosine of a path and another one that goes against it, and how many times as far it goes."""
    against, own, others = -float((path * other).sum()), float((path**2).sum()), float((other**2).sum())
    return (against / np.sqrt(own * others), own / against) if against > 0 else (0.0, 0.0)


def cut_words(part: slice, n_frames: int, why: str, first_frame: int = 0, before: str = "") -> str:
    """The frames that are cut off at the ends, in words, after those cut off `before`."""
    ends = [(0, part.start), (part.stop, n_frames)]
    ranges = [(first_frame + a, first_frame + b - 1) for a, b in ends if b > a]
    names = [f"frame {a}" if a == b else f"frames {a} to {b}" for a, b in ranges]
    return "; ".join(filter(None, [before, f"{' and '.join(names)} cut off: {why}" if names else ""]))
