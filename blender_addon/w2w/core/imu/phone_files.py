# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of phones and watches, as their apps export them: columns, units and clocks recognised or asked.

Physics Toolbox, phyphox, Sensor Logger and SensorLog are known by their columns; others by words and units in
theirs. A file counts only if gravity is in its acceleration: the median size says so, whatever the file says.
"""

import csv
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..csv_tables import SEPARATORS, decoded
from ..wording import listed, shown
from .clock import at_times, shared_times
from .phone_clocks import LOST_S, number_in, rate_of, seconds_of
from .recording import ImuRecording
from .text_tables import ACC_UNITS, GYR_UNITS

SENSOR_FILES = re.compile(
    r"(wrist ?motion|raw data|gravity|((total|linear|user)[ _]?)?acc(eleration|elerometer)?|gyro(scope)?)"
    r"([ _]?uncalibrated)?\.(csv|txt)",
    re.IGNORECASE,
)
"""Names of files of which a folder is one recording."""

SPELLED = {
    "g": ACC_UNITS["g"], "m/s2": 1.0, "ms2": 1.0, "m/s/s": 1.0, "rad/s": 1.0, "rads": 1.0,
    "deg/s": GYR_UNITS["deg/s"], "dps": GYR_UNITS["deg/s"], "degs": GYR_UNITS["deg/s"],
}  # fmt: skip
"""Units without spaces, signs of powers and degrees, in m/s2 and rad/s."""

TIMES = re.compile(
    r"(seconds_?elapsed|elapsed( ?time)?|time(stamp)?([ _]?(s|ms|us|ns))?|t|loggingtime|date ?time|epoch)"
    r"|(accelerometer|motion|gyro)timestamp_sincereboot",
    re.IGNORECASE,
)
LEAST_G, MOST_G = 0.6, 1.4
"""What acceleration with gravity is in the mean over a second, in g; without it next to nothing."""

FASTEST_TURN, LONGEST_TURN = 70.0, 12.0
"""Rad/s that no gyroscope of a phone or watch reads, and that nobody turns with for half a second on end."""

TURNED = 0.5, 8.0
"""Radians that gravity must turn for the gyroscope to be held against it, and how much less that may say."""

SHORTEST_S = 2.0


class _Group(NamedTuple):
    """Three columns of one quantity."""

    kind: str  # {"acc", "linear", "gravity", "gyr", "unsure"}
    unit: float  # in SI; NaN if it is not said
    times: np.ndarray  # (T,), s
    values: np.ndarray  # (T, 3), as in the file
    flipped: bool  # Apple's sign: at rest the acceleration points down
    name: str


def is_phone_folder(path: Path) -> bool:
    """Whether the files in a folder are the sensors of one recording."""
    return path.is_dir() and any(SENSOR_FILES.fullmatch(file.name) for file in path.iterdir())


def read_phone(path: Path) -> ImuRecording:
    """Read what an app wrote of one recording: a file, or a folder of a file for each sensor.

    Raises ValueError if a unit, a clock or gravity is in doubt; the message says what to do.
    """
    files = [path]
    if path.is_dir():
        files = [file for file in sorted(path.iterdir()) if SENSOR_FILES.fullmatch(file.name)]
    apple = _standard_apple(path if path.is_dir() else path.parent)
    groups = [group for file in files for group in _groups(file, apple)]
    acc = _with_gravity(groups, path)
    gyr = _turning(groups, acc, path)
    known = [group for group in (acc, gyr) if group is not None]
    rate = min(rate_of(group.times, path) for group in known)
    times = shared_times([group.times for group in known], rate, SHORTEST_S)
    found = [at_times(one.times, one.values, times, max(LOST_S, 4 / rate))[:, None] for one in known]
    return ImuRecording(found[0], found[1] if gyr else np.zeros_like(found[0]), rate)


def _standard_apple(folder: Path) -> bool | None:
    """Whether Sensor Logger's note beside its files says that Apple's sign is kept; None without a note."""
    note = folder / "Metadata.csv"
    if not note.is_file():
        return None
    rows = list(csv.reader(decoded(note)[0].splitlines()))[:2]
    facts = dict(zip(*rows, strict=False)) if len(rows) == 2 else {}
    kept = "true" not in facts.get("standardisation", "").lower()
    return "ios" in facts.get("platform", "").lower() and kept


def _groups(path: Path, apple: bool | None) -> Iterator[_Group]:
    """The quantities in a file that have three axes, each with its own clock where the file has several."""
    names, cells = _table(path)
    plain = [_plain(name) for name in names]
    stamps = [number for number, (name, _) in enumerate(plain) if TIMES.fullmatch(name)]
    if not stamps:
        raise ValueError(f"{shown(path.name)} has no column of times: its columns are {listed(names)}")
    columns: dict[tuple[str, str, str, float, bool], dict[str, int]] = {}
    for number, (name, unit) in enumerate(plain):
        if number not in stamps and (found := _quantity(name, unit, path, plain)):
            what, axis = found[:-1], found[-1]
            columns.setdefault((what[0], what[1], what[2], what[3], what[4]), {}).setdefault(axis, number)
    for (name, kind, app, factor, flipped), axes in columns.items():
        if len(axes) < 3:
            continue
        own = [n for n in stamps if app and plain[n][0].lower().startswith(app)]
        numbers = [[row[axes[axis]] for axis in "xyz"] for row in cells]
        values = np.array([[number_in(cell, path) for cell in row] for row in numbers])
        there = np.isfinite(values).all(axis=1)
        stamp = _best(own or stamps, plain)
        times = seconds_of([row[stamp] for row in cells], plain[stamp], path)
        there &= np.isfinite(times)
        if there.sum() < 2:
            continue
        order = np.flatnonzero(there)[np.argsort(times[there], kind="stable")]
        later = order[np.concatenate([[True], np.diff(times[order]) > 0])]
        yield _Group(kind, factor, times[later], values[later], flipped or bool(apple), name)


def _best(stamps: Sequence[int], plain: Sequence[tuple[str, str]]) -> int:
    """The column of seconds since the start where there is one."""
    return next((n for n in stamps if "elapsed" in plain[n][0].lower()), stamps[0])


def _table(path: Path) -> tuple[list[str], list[list[str]]]:
    """Names of the columns and the rows, by whatever separates them; lines above are passed over."""
    lines = decoded(path)[0].splitlines()
    for first, line in enumerate(lines[:50]):
        for mark in SEPARATORS:
            names = [cell.strip() for cell in next(csv.reader([line], delimiter=mark), [])]
            if len(names) >= 4 and any(TIMES.fullmatch(_plain(name)[0]) for name in names):
                rows = [row for row in csv.reader(lines[first + 1 :], delimiter=mark) if any(row)]
                if rows and len(rows[-1]) < len(names):
                    rows.pop()  # an app that was stopped
                if any(len(row) < len(names) for row in rows):
                    raise ValueError(
                        f"{shown(path.name)} has rows with fewer fields than its header: mend it"
                    )
                return names, rows
    raise ValueError(f"{shown(path.name)} has no line that names a time and three axes")


def _plain(name: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit as `SPELLED` and `CLOCKS` have it."""
    split = re.fullmatch(r"(.*?)[\s_]*[(\[]([^()\[\]]*)[)\]]\s*", name)
    unit = split[2].replace("²", "2").replace("µ", "u").replace("°", "deg") if split else ""
    unit = re.sub(r"[\s^*·]|\*\*", "", unit).lower().replace("s-", "/s").replace("/s1", "/s")
    return (split[1] if split else name).strip(), unit


def _quantity(
    name: str, unit: str, path: Path, plain: Sequence[tuple[str, str]]
) -> tuple[str, str, str, float, bool, str] | None:
    """Name, kind, clock's first letters, unit, sign and axis of a column; None for what is of no use."""
    others = {other.lower() for other, _ in plain}
    if toolbox := re.fullmatch(r"(gF|w)([xyz])", name):
        alone = others & {"time"} and not others & {"gx", "acc_x"}
        factor = SPELLED.get(unit, {"gF": SPELLED["g"], "w": 1.0 if alone else np.nan}[toolbox[1]])
        return toolbox[1], {"gF": "acc", "w": "gyr"}[toolbox[1]], "", factor, False, toolbox[2]
    split = re.fullmatch(r"(.*?)[\s_.\-]*([xyzXYZ])(?:[\s_\-]?axis)?", name)
    if split is None:
        return None
    words, axis = split[1], split[2].lower()
    logger = "seconds_elapsed" in others
    text = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", words or path.stem).lower().replace("_", " ")
    if re.search(
        r"quat|attitude|orient|magn|field|locat|heading|euler|position|vector|head(phone|set)", text
    ):
        return None
    kind = next((kind for kind, pattern in KINDS.items() if re.search(pattern, text)), "")
    if not kind:
        kind = "gyr" if unit in TURNS else "acc" if unit in ("g", "m/s2", "ms2", "m/s/s") else "unsure"
    log = re.match(r"(accelerometer|motion|gyro)", words) if _is_sensor_log(others) else None
    if logger and kind == "acc" and "total" not in text and "uncal" not in text:
        kind = "linear"  # Sensor Logger takes gravity out of what it calls acceleration
    known = np.nan
    if logger and kind != "unsure":
        known = np.nan if "wrist" in path.stem.lower() and kind != "gyr" else 1.0
        known = np.nan if "uncal" in text and kind != "gyr" else known
    elif log:
        known = 1.0 if kind == "gyr" else SPELLED["g"]
    if (kind == "gyr") != (unit in TURNS) and unit in SPELLED:
        return None  # an angle, or a gyroscope in g: no such thing
    factor = SPELLED.get(unit, np.nan if unit else known)
    return words, kind, log[1] if log else "", factor, bool(log), axis


KINDS = {
    "gyr": r"gyr|rotation ?rate|angular ?(vel|rate)|omega",
    "linear": r"linear|user|lin ?acc|without ?g",
    "gravity": r"grav",
    "acc": r"acc|^a$|g ?force",
}
TURNS = ("rad/s", "rads", "deg/s", "dps", "degs")


def _is_sensor_log(names: set[str]) -> bool:
    return any(re.match(r"loggingtime|(motion|accelerometer|gyro)timestamp_", name) for name in names)


def _with_gravity(groups: Sequence[_Group], path: Path) -> _Group:
    """Acceleration with gravity in it, m/s2; where an app parts the two, their sum."""
    sizes = {}
    for group in groups:
        if group.kind in ("acc", "gravity", "linear"):
            size = float(np.median(np.linalg.norm(_means(group, 1.0), axis=1)))
            fits = [u for u in ((group.unit,) if np.isfinite(group.unit) else (1.0, ACC_UNITS["g"]))
                    if LEAST_G <= size * u / ACC_UNITS["g"] <= MOST_G]  # fmt: skip
            if group.kind == "acc" and fits:
                return _si(group, fits[0])
            sizes[group.kind] = (group, size, fits[0] if fits else None)
    linear, gravity = (sizes.get(kind) for kind in ("linear", "gravity"))
    if linear and gravity and gravity[2]:
        own, down = linear[0], gravity[0]
        factor = own.unit if np.isfinite(own.unit) else gravity[2]
        both = at_times(down.times, down.values * gravity[2], own.times, LOST_S) + own.values * factor
        whole = np.isfinite(both).all(axis=1)
        return _si(own._replace(times=own.times[whole], values=both[whole]), 1.0)
    if not sizes:
        raise ValueError(
            f"{shown(path.name)} has no acceleration of three axes with words or units that are known"
        )
    group, size, _ = next(iter(sizes.values()))
    raise ValueError(
        f"{shown(path.name)}: acceleration '{group.name or path.stem}' is {size:.3g} in the mean over a "
        "second, and not gravity's 9.8 m/s2 or 1 g. W2W needs it with gravity: in the app choose the "
        "accelerometer, g-force or total acceleration instead of linear or user acceleration, or record "
        "gravity as well"
    )


def _si(group: _Group, factor: float) -> _Group:
    return group._replace(values=group.values * (-factor if group.flipped else factor), unit=1.0)


def _turning(groups: Sequence[_Group], acc: _Group, path: Path) -> _Group | None:
    """Angular velocity, rad/s; None where none was recorded."""
    found = [group for group in groups if group.kind == "gyr"]
    unsure = [group for group in groups if group.kind == "unsure"]
    if not found and unsure:
        raise ValueError(
            f"{shown(path.name)}: what '{unsure[0].name}' holds is not known: name it in the header, "
            "as in 'gyr_x (deg/s)'"
        )
    if not found:
        return None
    group = next((one for one in found if np.isfinite(one.unit)), found[0])
    if not np.isfinite(group.unit):
        raise ValueError(
            f"{shown(path.name)} does not say the unit of '{group.name}': write it in the header, "
            "as in 'gyr_x (deg/s)' or 'gyr_x (rad/s)'"
        )
    group = group._replace(values=group.values * group.unit)
    half, up = _means(group, 0.5), _means(acc, 0.5)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    gravity = np.arccos(np.clip((up[1:] * up[:-1]).sum(axis=1), -1, 1)).sum()
    turned = np.linalg.norm(half, axis=1)
    fastest = np.quantile(np.abs(group.values), 0.99)
    least, share = TURNED
    slow = gravity > least and turned.sum() * 0.5 < gravity / share
    if fastest > FASTEST_TURN or turned.mean() > LONGEST_TURN or slow:
        raise ValueError(
            f"{shown(path.name)}: '{group.name}' turns much {'slower' if slow else 'faster'} than the "
            "acceleration lets it: its unit is not what is said"
        )
    return group


def _means(group: _Group, seconds: float) -> np.ndarray:
    """Means over each so many seconds, (M, 3)."""
    span = np.floor((group.times - group.times[0]) / seconds).astype(int)
    _, first = np.unique(span, return_index=True)
    return np.add.reduceat(group.values, first) / np.diff([*first, len(span)])[:, None]
