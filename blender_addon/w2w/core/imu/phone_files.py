# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of phones and watches, as their apps export them: columns, units and clocks recognised or asked.

Physics Toolbox, phyphox, Sensor Logger and SensorLog are known by their columns; others by words and units in
theirs. A file counts only if gravity is in its acceleration: the median size says so, whatever the file says.
"""

import csv
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..csv_tables import SEPARATORS, decoded
from ..wording import clean, restated
from .clock import LOST_S, at_times, in_order, number_in, rate_of, seconds_of, shared_times
from .recording import ImuRecording
from .vendor_formats import ACC_UNITS, GYR_UNITS

SENSOR_FILES = re.compile(
    r"(wrist ?motion|raw data|gravity|((total|linear|user)[ _]?)?acc(eleration|elerometer)?|gyro(scope)?)"
    r"([ _]?uncalibrated)?\.(csv|txt)",
    re.IGNORECASE,
)
"""Names of files of which a folder is one recording."""

G, DEGREE = ACC_UNITS["g"], GYR_UNITS["deg/s"]
PULLS = {"g": G, "m/s2": 1.0, "ms2": 1.0, "m/s/s": 1.0}
TURNS = {"rad/s": 1.0, "rads": 1.0, "deg/s": DEGREE, "dps": DEGREE, "degs": DEGREE}
"""Units without spaces, signs of powers and degrees, in m/s2 and rad/s."""

KINDS = {
    "": r"quat|attitude|orient|magn|field|locat|heading|euler|position|vector|head(phone|set)",
    "gyr": r"gyr|rotation ?rate|angular ?(vel|rate)|omega|^w$",
    "linear": r"linear|user|lin ?acc|without ?g",
    "gravity": r"grav",
    "acc": r"acc|^a$|g ?force|^g f$",
}
"""What words in the name of a column or file mean, the first that fit; the first are of no use."""

SENSOR_LOG = re.compile(r"loggingtime|(motion|accelerometer|gyro)timestamp_")
"""Columns by which SensorLog is known."""

TIMES = re.compile(
    r"(seconds_?elapsed|elapsed( ?time)?|time(stamp)?([ _]?(s|ms|us|ns))?|t|loggingtime|date ?time|epoch)"
    r"|time since start( in ms)?|zeit|temps|tiempo|tempo"
    r"|(accelerometer|motion|gyro)timestamp_sincereboot",
    re.IGNORECASE,
)
LEAST_G, MOST_G = 0.6, 3.3
"""What acceleration with gravity is in the mean over a second at least, in g; without it next to nothing.

And its mean size at most: real recordings have .5 to 2.2 g, so none less than 4.8 in m/s2.
"""

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

    def si(self, factor: float) -> "_Group":
        """The group in SI units, its sign that of specific force."""
        sign = -1 if self.flipped and self.kind != "gyr" else 1
        return self._replace(values=sign * factor * self.values, unit=1.0, flipped=False)

    def means(self, seconds: float) -> np.ndarray:
        """Means over each so many seconds, (M, 3)."""
        span = np.floor((self.times - self.times[0]) / seconds).astype(int)
        _, first = np.unique(span, return_index=True)
        return np.add.reduceat(self.values, first) / np.diff([*first, len(span)])[:, None]


def is_phone_folder(path: Path) -> bool:
    """Whether the files in a folder are the sensors of one recording."""
    return path.is_dir() and any(SENSOR_FILES.fullmatch(file.name) for file in path.iterdir())


def read_phone(path: Path) -> ImuRecording:
    """Read what an app wrote of one recording: a file, or a folder of a file for each sensor.

    Raises ValueError if a unit, a clock or gravity is in doubt; the message says what to do.
    """
    files, folder = [path], path.parent
    if path.is_dir():
        files, folder = [one for one in sorted(path.iterdir()) if SENSOR_FILES.fullmatch(one.name)], path
    with restated(f"{clean(path.name)}:", ValueError):
        groups = [group for file in files for group in _groups(file, _keeps_apples_sign(folder))]
        acc = _with_gravity(groups)
        gyr = _turning(groups, acc)
        known = [group for group in (acc, gyr) if group is not None]
        rate = min(rate_of(group.times) for group in known)
        times = shared_times([group.times for group in known], rate, SHORTEST_S)
        found = [at_times(one.times, one.values, times, max(LOST_S, 4 / rate))[:, None] for one in known]
    return ImuRecording(found[0], found[1] if gyr else np.zeros_like(found[0]), rate)


def _keeps_apples_sign(folder: Path) -> bool:
    """Whether Sensor Logger's note beside its files says so."""
    note = folder / "Metadata.csv"
    rows = csv.DictReader(decoded(note)[0].lower().splitlines()) if note.is_file() else ()
    facts = [(row.get("platform") or "", row.get("standardisation") or "") for row in rows]
    return any("ios" in platform and "true" not in standard for platform, standard in facts)


def _groups(path: Path, apple: bool) -> Iterator[_Group]:
    """The quantities in a file that have three axes, each with its own clock where the file has several."""
    names, cells = _table(path)
    plain = [_plain(name) for name in names]
    stamps = [number for number, (name, _) in enumerate(plain) if TIMES.fullmatch(name)]
    columns: dict[tuple[Any, ...], dict[str, int]] = {}
    for number, (name, unit) in enumerate(plain):
        if number not in stamps and (found := _quantity(name, unit, path.stem, plain)):
            columns.setdefault(found[:-1], {}).setdefault(found[-1], number)
    for (name, kind, app, factor, flipped), axes in columns.items():
        if len(axes) < 3:
            continue
        clocks = [n for n in stamps if app and plain[n][0].lower().startswith(app)] or stamps
        stamp = next((n for n in clocks if "elapsed" in plain[n][0].lower()), clocks[0])
        values = np.array([[number_in(row[axes[axis]]) for axis in "xyz"] for row in cells])
        times = seconds_of([row[stamp] for row in cells], *plain[stamp])
        there = np.flatnonzero(np.isfinite(values).all(axis=1) & np.isfinite(times))
        if (np.diff(times[there]) < -1).any():
            raise ValueError("its times go back: it holds several recordings, so part them into files")
        later = in_order(times, there)
        if len(later) > 2:
            yield _Group(kind, factor, times[later], values[later], flipped or apple, name)


def _table(path: Path) -> tuple[list[str], list[list[str]]]:
    """Names of the columns and the rows, by whatever separates them; lines above are passed over."""
    lines = decoded(path)[0].splitlines()
    for first, line in enumerate(lines[:50]):
        for mark in SEPARATORS:
            names = [cell.strip() for cell in next(csv.reader([line], delimiter=mark), [])]
            if len(names) >= 4 and any(TIMES.fullmatch(_plain(name)[0]) for name in names):
                rows = [row for row in csv.reader(lines[first + 1 :], delimiter=mark) if any(row)]
                whole = [row for row in rows if len(row) >= len(names)]
                if len(whole) < max(len(rows) - 1, 3):  # an app that was stopped cuts the last
                    raise ValueError("rows have fewer fields than the header: mend it")
                return names, whole
    raise ValueError("no line names a time and three axes")


def _plain(name: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit as the tables have it."""
    split = re.fullmatch(r"(.*?)[\s_]*[(\[]([^()\[\]]*)[)\]]\s*", name)
    unit = split[2].replace("²", "2").replace("µ", "u").replace("°", "deg") if split else ""
    unit = re.sub(r"[\s^*·]", "", unit).lower().replace("s-", "/s").replace("/s1", "/s")
    return (split[1] if split else name).strip(), unit


def _quantity(
    name: str, unit: str, stem: str, plain: Sequence[tuple[str, str]]
) -> tuple[str, str, str, float, bool, str] | None:
    """Name, kind, clock's first letters, unit, sign and axis of a column; None for what is of no use."""
    split = re.fullmatch(r"(.*?)[\s_.\-]*([xyzXYZ])(?:[\s_\-]?axis)?", name)
    if split is None:
        return None
    others, words = {other.lower() for other, _ in plain}, split[1]
    text = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", words or stem).lower().replace("_", " ")
    by_unit = "gyr" if unit in TURNS else "acc" if unit in PULLS else "unsure"
    kind = next((kind for kind, pattern in KINDS.items() if re.search(pattern, text)), by_unit)
    if not kind or (unit in {**PULLS, **TURNS} and (kind == "gyr") != (unit in TURNS)):
        return None  # an angle, or a gyroscope in g: no such thing
    known, app, raw = np.nan, "", "uncal" in text or "wrist" in stem.lower()
    if "seconds_elapsed" in others:  # Sensor Logger takes gravity out of what it calls acceleration
        kind = "linear" if kind == "acc" and "total" not in text and "uncal" not in text else kind
        known = 1.0 if kind == "gyr" or not raw else np.nan
    elif any(map(SENSOR_LOG.match, others)) and (log := re.match(r"accelerometer|motion|gyro", words)):
        known, app = 1.0 if kind == "gyr" else G, log[0]
    elif words in ("gF", "w") and not others & {"gx", "acc_x"}:  # Physics Toolbox
        known = G if words == "gF" else 1.0
    factor = {**PULLS, **TURNS}.get(unit, np.nan if unit else known)
    apples = bool(app) or stem.lower() == "headphone" or (kind == "linear" and "user acc" in text)
    return words, kind, app, factor, apples, split[2].lower()


def _with_gravity(groups: Sequence[_Group]) -> _Group:
    """Acceleration with gravity in it, m/s2; where an app parts the two, their sum."""
    sizes: dict[str, tuple[_Group, float, float]] = {}
    for group in groups:
        if group.kind in ("acc", "gravity", "linear"):
            size = float(np.median(np.linalg.norm(group.means(1.0), axis=1)))
            units = (group.unit,) if np.isfinite(group.unit) else (1.0, G)
            most = float(np.linalg.norm(group.values, axis=1).mean())
            fit = next((u for u in units if size * u / G >= LEAST_G and most * u / G <= MOST_G), np.nan)
            if group.kind == "acc" and np.isfinite(fit):
                return group.si(fit)
            sizes[group.kind] = group, size, fit
    if {"linear", "gravity"} <= sizes.keys() and np.isfinite(sizes["gravity"][2]):
        own, (down, _, unit) = sizes["linear"][0], sizes["gravity"]
        factor = own.unit if np.isfinite(own.unit) else unit
        both = at_times(down.times, down.values * unit, own.times, LOST_S) + own.values * factor
        whole = np.isfinite(both).all(axis=1)
        return own._replace(times=own.times[whole], values=both[whole]).si(1.0)
    if not sizes:
        raise ValueError("no acceleration of three axes has words or units that are known")
    group, size, _ = next(iter(sizes.values()))
    raise ValueError(
        f"acceleration '{group.name or group.kind}' is {size:.3g} in the mean over a second, and not "
        "gravity's 9.8 m/s2 or 1 g. W2W needs it with gravity: in the app choose the accelerometer, g-force "
        "or total acceleration instead of linear or user acceleration, or record gravity as well"
    )


def _turning(groups: Sequence[_Group], acc: _Group) -> _Group | None:
    """Angular velocity, rad/s; None where none was recorded."""
    found = [one for kind in ("gyr", "unsure") for one in groups if one.kind == kind]
    if not found:
        return None
    group = next((one for one in found if np.isfinite(one.unit)), found[0])
    if not np.isfinite(group.unit):
        raise ValueError(f"say in the header what '{group.name}' is and in which unit, as in 'gyr_x (deg/s)'")
    group = group.si(group.unit)
    up, turned = acc.means(0.5), np.linalg.norm(group.means(0.5), axis=1)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    gravity = np.arccos(np.clip((up[1:] * up[:-1]).sum(axis=1), -1, 1)).sum()
    least, share = TURNED
    slow = gravity > least and turned.sum() * 0.5 < gravity / share
    if slow or np.quantile(np.abs(group.values), 0.99) > FASTEST_TURN or turned.mean() > LONGEST_TURN:
        how = "slower" if slow else "faster"
        raise ValueError(f"'{group.name}' turns {how} than the acceleration lets it: its unit is not as said")
    return group
