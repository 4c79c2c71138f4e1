# ruff: noqa: E501
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of phone and watch apps of one known motion, as each app writes them, and ways in which they differ."""

# fmt: off
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

G = 9.80665
RATE, SECONDS = 50, 12


def motion(seconds: float = SECONDS) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times (T,), s, gravity's part and the rest of the specific force (T, 3), m/s2, angular velocity (T, 3)."""
    t = np.arange(round(seconds * RATE)) / RATE
    tilt = 0.5 * np.sin(2 * np.pi * 0.4 * t)
    up = np.stack([np.sin(tilt), 0.2 * np.ones_like(t), np.cos(tilt)], axis=1)
    gravity = G * up / np.linalg.norm(up, axis=1, keepdims=True)
    moved = 2 * np.stack([np.sin(9 * t), np.cos(7 * t), np.sin(5 * t)], axis=1)
    gyr = np.stack([0.1 * np.cos(3 * t), 0.5 * 2 * np.pi * 0.4 * np.cos(2 * np.pi * 0.4 * t), 0.3 * np.sin(t)], axis=1)
    return t, gravity, moved, gyr


def table(
    path: Path,
    names: list[str],
    *columns: np.ndarray | list[str],
    mark: str = ",",
    comma: bool = False,
    quoted: bool = False,
    head: str = "",
    encoding: str = "utf-8",
    end: str = "\n",
) -> Path:
    """Write a csv file; `comma` writes decimals as in Germany."""

    def cell(value: object) -> str:
        text = value if isinstance(value, str) else str(value) if isinstance(value, int) else f"{value:.9g}"
        text = text.replace(".", ",") if comma and not isinstance(value, str) else text
        return f'"{text}"' if quoted else text

    flat = [list(c) if isinstance(c, list) else c.T.tolist() if c.ndim == 2 else [c.tolist()] for c in columns]
    lists = [one for c in flat for one in (c if c and isinstance(c[0], list) else [c])]
    rows = [mark.join(map(cell, row)) for row in zip(*lists, strict=True)]
    header = mark.join(f'"{name}"' if quoted else name for name in names)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes((head + end.join([header, *rows]) + end).encode(encoding))
    return path


def rounded(path: Path, head: str, times: np.ndarray, values: np.ndarray, mark: str = ",", form: str = ".5f", end: str = "", foot: str = "") -> Path:
    """Write a csv file whose numbers have so many digits, rows of which some app ends in its own way."""
    rows = [mark.join(format(v, form) for v in row) + end for row in np.column_stack([times, values]).tolist()]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([head, *rows, foot]))
    return path


T, GRAVITY, MOVED, GYR = motion()
ACC = GRAVITY + MOVED
START = 1_700_000_000
EPOCH_NS = [START * 10**9 + round(t * 1e9) for t in T]
XYZ_ACC = [f"Acceleration {a} (m/s^2)" for a in "xyz"]
XYZ_GYR = [f"Gyroscope {a} (rad/s)" for a in "xyz"]
LOGGER = ["time", "seconds_elapsed", "z", "y", "x"]


def iso(offset: str = "", digits: int = 3) -> list[str]:
    """Dates and times of the samples."""
    base = datetime(2024, 5, 1, 10, 11, 12, tzinfo=UTC)
    return [(base + timedelta(seconds=t)).strftime("%Y-%m-%d %H:%M:%S.%f")[: 20 + digits] + offset for t in T.tolist()]


def clock(start: str = "23:59:55", mark: str = ":") -> list[str]:
    """Times of day with milliseconds after a mark."""
    base = datetime.strptime(start, "%H:%M:%S").replace(tzinfo=UTC)
    return [(base + timedelta(seconds=t)).strftime(f"%H:%M:%S{mark}%f")[:-3] for t in T.tolist()]


def logger(folder: Path, files: dict[str, np.ndarray], platform: str = "android", standard: str = "false") -> Path:
    """Sensor Logger's folder: a file for each sensor, columns z, y, x, and a note on the phone."""
    for name, values in files.items():
        table(folder / f"{name}.csv", LOGGER, EPOCH_NS, T, values[:, ::-1])
    table(folder / "Metadata.csv", ["version", "platform", "standardisation"], ["3"], [platform], [standard])
    table(folder / "Location.csv", ["time", "seconds_elapsed", "longitude", "latitude"], EPOCH_NS, T, ACC[:, :2])
    return folder


def sensor_log(unit: str = "(G)", turn: str = "(rad/s)") -> list[str]:
    """SensorLog's names of columns."""
    return [
        f"loggingTime{'(txt)' if unit else ''}",
        f"motionTimestamp_sinceReboot{'(s)' if unit else ''}",
        *(f"motionUserAcceleration{a}{unit}" for a in "XYZ"),
        *(f"motionGravity{a}{unit}" for a in "XYZ"),
        *(f"motionRotationRate{a}{turn}" for a in "XYZ"),
        *(f"motionQuaternion{a}{'(R)' if unit else ''}" for a in "XYZW"),
    ]


QUATERNION = np.tile([0.0, 0.0, 0.0, 1.0], (len(T), 1))
WRIST = ["time", "seconds_elapsed", *(f"{kind}{a}" for kind in ("rotationRate", "gravity", "acceleration") for a in "XYZ")]

Write = Callable[[Path], Path]


def right() -> dict[str, tuple[Write, float, bool]]:
    """Files that say enough: what writes each, the sign of its acceleration, and whether it has a gyroscope."""
    apple = sensor_log()
    w = ["wx", "wy", "wz"]
    gf = ["gFx", "gFy", "gFz"]
    andro = [f"{kind} {a} (m/s²)" for kind in ("ACCELEROMETER", "GRAVITY", "LINEAR ACCELERATION") for a in "XYZ"]
    andro += [f"GYROSCOPE {a} (rad/s)" for a in "XYZ"]
    return {
        "toolbox g-force": (lambda p: table(p / "a.csv", ["time", *gf, "TgF"], T, ACC / G, np.linalg.norm(ACC / G, axis=1)), 1, False),
        "toolbox g-force, gyroscope": (lambda p: table(p / "a.csv", ["time", *gf, *w], T, ACC / G, GYR), 1, True),
        "toolbox, everything": (lambda p: table(p / "a.csv", ["time", *gf, "ax", "ay", "az", *w, "p", "Bx", "By", "Bz"], T, ACC / G, MOVED, GYR, 1013 + T, 40 * QUATERNION[:, :3]), 1, True),
        "toolbox, semicolons and decimal commas": (lambda p: table(p / "a.csv", ["time", *gf, *w], T, ACC / G, GYR, mark=";", comma=True), 1, True),
        "toolbox, printed minus signs under a blank line": (lambda p: table(p / "a.csv", ["time", *gf, "Gain"], T, [[f"{v:.6f}".replace("-", "\N{MINUS SIGN}").replace(".", ",") for v in axis] for axis in (ACC / G).T.tolist()], ["\N{MINUS SIGN}\N{INFINITY}"] * len(T), mark=";", comma=True, head="\n"), 1, False),
        "toolbox, time of day over midnight": (lambda p: table(p / "a.csv", ["time", *gf, *w], clock(), ACC / G, GYR), 1, True),
        "toolbox, time of day with a point": (lambda p: table(p / "a.csv", ["time", *gf, *w], clock("08:00:00", "."), ACC / G, GYR), 1, True),
        "toolbox, dates": (lambda p: table(p / "a.csv", ["time", *gf], iso(), ACC / G), 1, False),
        "toolbox, blank ends of rows": (lambda p: table(p / "a.csv", ["time", *gf, ""], T, ACC / G, [""] * len(T)), 1, False),
        "phyphox, comma": (lambda p: table(p / "Raw Data.csv", ["Time (s)", *XYZ_ACC, "Absolute acceleration (m/s^2)"], T, ACC, np.linalg.norm(ACC, axis=1), quoted=True), 1, False),
        "phyphox, tabs": (lambda p: table(p / "Raw Data.csv", ["Time (s)", *XYZ_ACC], T, ACC, mark="\t"), 1, False),
        "phyphox, semicolons and decimal commas": (lambda p: table(p / "Raw Data.csv", ["Time (s)", *XYZ_ACC], T, ACC, mark=";", comma=True), 1, False),
        "phyphox, quoted decimal commas": (lambda p: table(p / "Raw Data.csv", ["Time (s)", *XYZ_ACC], T, ACC, comma=True, quoted=True), 1, False),
        "phyphox, two files": (lambda p: table(table(p / "Accelerometer.csv", ["Time (s)", *XYZ_ACC], T, ACC).parent / "Gyroscope.csv", ["Time (s)", *XYZ_GYR], T, GYR).parent, 1, True),
        "phyphox, two files of bare axes": (lambda p: table(table(p / "Accelerometer.csv", ["Time (s)", "X (m/s^2)", "Y (m/s^2)", "Z (m/s^2)"], T, ACC).parent / "Gyroscope.csv", ["Time (s)", "X (rad/s)", "Y (rad/s)", "Z (rad/s)"], T, GYR).parent, 1, True),
        "phyphox, with the linear one beside": (lambda p: table(table(p / "Accelerometer.csv", ["Time (s)", *XYZ_ACC], T, ACC).parent / "Linear Accelerometer.csv", ["Time (s)", *(f"Linear Acceleration {a} (m/s^2)" for a in "xyz")], T, MOVED).parent, 1, False),
        "phyphox, clocks of the files apart": (lambda p: table(table(p / "Accelerometer.csv", ["Time (s)", *XYZ_ACC], T[3:], ACC[3:]).parent / "Gyroscope.csv", ["Time (s)", *XYZ_GYR], T[:-5], GYR[:-5]).parent, 1, True),
        "logger, Android": (lambda p: logger(p, {"TotalAcceleration": ACC, "Accelerometer": MOVED, "Gravity": GRAVITY, "Gyroscope": GYR}), 1, True),
        "logger, Android without gravity's file": (lambda p: logger(p, {"TotalAcceleration": ACC, "Accelerometer": MOVED, "Gyroscope": GYR}), 1, True),
        "logger, parts to be added": (lambda p: logger(p, {"Accelerometer": MOVED, "Gravity": GRAVITY, "Gyroscope": GYR}), 1, True),
        "logger, iPhone": (lambda p: logger(p, {"Accelerometer": -MOVED, "Gravity": -GRAVITY, "Gyroscope": GYR}, "ios"), 1, True),
        "logger, iPhone standardised": (lambda p: logger(p, {"Accelerometer": MOVED, "Gravity": GRAVITY, "Gyroscope": GYR}, "ios", "true"), 1, True),
        "logger, uncalibrated in g": (lambda p: logger(p, {"AccelerometerUncalibrated": -ACC / G, "GyroscopeUncalibrated": GYR}, "ios"), 1, True),
        "logger, one file alone": (lambda p: table(p / "TotalAcceleration.csv", LOGGER, EPOCH_NS, T, ACC[:, ::-1]), 1, False),
        "logger, Apple watch in g": (lambda p: table(p / "WristMotion.csv", WRIST, EPOCH_NS, T, GYR, -GRAVITY / G, -MOVED / G), -1, True),
        "logger, watch in m/s2": (lambda p: table(p / "WristMotion.csv", WRIST, EPOCH_NS, T, GYR, GRAVITY, MOVED), 1, True),
        "log, with units": (lambda p: table(p / "a.csv", apple, iso(" +0900"), T + 5000, -MOVED / G, -GRAVITY / G, GYR, QUATERNION), 1, True),
        "log, without units": (lambda p: table(p / "a.csv", sensor_log("", ""), iso(), T + 5000, -MOVED / G, -GRAVITY / G, GYR, QUATERNION), 1, True),
        "log, raw accelerometer": (lambda p: table(p / "a.csv", ["loggingTime(txt)", "accelerometerTimestamp_sinceReboot(s)", *(f"accelerometerAcceleration{a}(G)" for a in "XYZ"), "gyroTimestamp_sinceReboot(s)", *(f"gyroRotation{a}(rad/s)" for a in "XYZ")], iso(), T + 77, -ACC / G, T + 77, GYR), 1, True),
        "log, dates alone": (lambda p: table(p / "a.csv", ["loggingTime(txt)", *(f"accelerometerAcceleration{a}(G)" for a in "XYZ")], iso(" +0100"), -ACC / G), 1, False),
        "other, milliseconds": (lambda p: table(p / "a.csv", ["timestamp", "acc_x", "acc_y", "acc_z", "gyro_x (deg/s)", "gyro_y (deg/s)", "gyro_z (deg/s)"], [START * 1000 + round(1000 * t) for t in T], ACC, np.degrees(GYR)), 1, True),
        "other, microseconds": (lambda p: table(p / "a.csv", ["timestamp_us", "AccX", "AccY", "AccZ"], [round(1e6 * t) for t in T], ACC / G), 1, False),
        "other, seconds since 1970": (lambda p: table(p / "a.csv", ["Timestamp", "accel x [g]", "accel y [g]", "accel z [g]", "gyro x [°/s]", "gyro y [°/s]", "gyro z [°/s]"], [f"{START + t:.4f}" for t in T], ACC / G, np.degrees(GYR)), 1, True),
        "other, UTF-16": (lambda p: table(p / "a.csv", ["Time (ms)", *XYZ_ACC, *XYZ_GYR], 1000 * T, ACC, GYR, mark="\t", encoding="utf-16"), 1, True),
        "other, powers and signs": (lambda p: table(p / "a.csv", ["time (s)", *(f"Acceleration {a} (m/s²)" for a in "xyz"), *(f"Angular velocity {a} (rad s^-1)" for a in "xyz")], T, ACC, GYR, encoding="cp1252"), 1, True),
        "other, lines above": (lambda p: table(p / "a.csv", ["time (s)", *XYZ_ACC], T, ACC, head="Device: Pixel\nStarted, 2024-05-01\n\n"), 1, False),
        "other, Windows' line ends": (lambda p: table(p / "a.csv", ["elapsed (s)", *XYZ_ACC], T, ACC, end="\r\n"), 1, False),
        "other, ISO with T": (lambda p: table(p / "a.csv", ["timestamp", "accelerometer_x", "accelerometer_y", "accelerometer_z"], [text.replace(" ", "T") + "Z" for text in iso()], ACC), 1, False),
        "toolbox, as it rounds": (lambda p: rounded(p / "a.csv", "time,gFx,gFy,gFz,TgF,", T, ACC / G, end=",1.0,"), 1, False),
        "toolbox, beside position and angles": (lambda p: table(p / "a.csv", ["time", *gf, *w, "p", "Azimuth", "Pitch", "Roll", " Latitude", "Longitude", "Speed (m/s)"], T, ACC / G, GYR, 1013 + T, QUATERNION[:, :3], QUATERNION[:, :2], T), 1, True),
        "toolbox, stopped in a row": (lambda p: rounded(p / "a.csv", "time,gFx,gFy,gFz", T, ACC / G, foot="12.0,0.1"), 1, False),
        "toolbox, milliseconds": (lambda p: table(p / "a.csv", ["time", *gf], [round(1000 * t) for t in T], ACC / G), 1, False),
        "phyphox, German": (lambda p: table(p / "Raw Data.csv", ["Zeit (s)", *(f"Beschleunigung {a} (m/s^2)" for a in "xyz")], T, ACC, mark=";", comma=True), 1, False),
        "phyphox, French": (lambda p: table(p / "Raw Data.csv", ["Temps (s)", *(f"Accélération {a} (m/s^2)" for a in "xyz")], T, ACC), 1, False),
        "phyphox, powers of ten": (lambda p: rounded(p / "Raw Data.csv", '"Time (s)","Acceleration x (m/s^2)","Acceleration y (m/s^2)","Acceleration z (m/s^2)"', T, ACC, form=".9E"), 1, False),
        "phyphox, none at first": (lambda p: table(p / "Raw Data.csv", ["Time (s)", *XYZ_ACC], T, [["NaN"] * 5 + [f"{v:.6f}" for v in axis[5:]] for axis in ACC.T.tolist()]), 1, False),
        "phyphox, all in one": (lambda p: table(p / "a.csv", ["Time (s)", *XYZ_ACC, *(f"Linear Acceleration {a} (m/s^2)" for a in "xyz"), *XYZ_GYR, *(f"Magnetic field {a} (µT)" for a in "xyz")], T, ACC, MOVED, GYR, QUATERNION[:, :3]), 1, True),
        "phyphox, degrees": (lambda p: table(table(p / "Accelerometer.csv", ["Time (s)", *XYZ_ACC], T, ACC).parent / "Gyroscope.csv", ["Time (s)", *(f"Gyroscope {a} (°/s)" for a in "xyz")], T, np.degrees(GYR)).parent, 1, True),
        "phyphox, other order of axes": (lambda p: table(p / "a.csv", ["Time (s)", *(f"Acceleration {a} (m/s^2)" for a in "zxy")], T, ACC[:, [2, 0, 1]]), 1, False),
        "logger, from before it began": (lambda p: table(p / "TotalAcceleration.csv", LOGGER, EPOCH_NS, T - 0.3, ACC[:, ::-1]), 1, False),
        "logger, times for people": (lambda p: table(p / "TotalAcceleration.csv", [*LOGGER[:2], "human_readable_time", *LOGGER[2:]], EPOCH_NS, T, iso("Z"), ACC[:, ::-1]), 1, False),
        "logger, iPhone's total": (lambda p: logger(p, {"TotalAcceleration": -ACC, "Accelerometer": -MOVED, "Gravity": -GRAVITY, "Gyroscope": GYR}, "ios"), 1, True),
        "logger, Wear OS with its turn": (lambda p: table(p / "WristMotion.csv", [*WRIST, *(f"quaternion{a}" for a in "WXYZ")], EPOCH_NS, T, GYR, GRAVITY, MOVED, QUATERNION), 1, True),
        "logger, Android uncalibrated": (lambda p: logger(p, {"AccelerometerUncalibrated": ACC, "GyroscopeUncalibrated": GYR}), 1, True),
        "logger, nanoseconds alone": (lambda p: table(p / "TotalAcceleration.csv", ["time", "z", "y", "x"], EPOCH_NS, ACC[:, ::-1]), 1, False),
        "logger, headphones": (lambda p: table(p / "Headphone.csv", WRIST, EPOCH_NS, T, GYR, -GRAVITY, -MOVED), 1, True),
        "log, all its columns": (lambda p: table(p / "a.csv", [*apple[:1], "locationTimestamp_since1970(s)", "locationHeadingX(µT)", "locationHeadingY(µT)", "locationHeadingZ(µT)", *apple[1:], "motionYaw(rad)", "activity(txt)"], iso(" +0200"), T + START, 40 * QUATERNION[:, :3], T + 62608, -MOVED / G, -GRAVITY / G, GYR, QUATERNION, T, ["walking"] * len(T)), 1, True),
        "log, semicolons": (lambda p: table(p / "a.csv", apple, iso(" +0900"), T + 5000, -MOVED / G, -GRAVITY / G, GYR, QUATERNION, mark=";", comma=True), 1, True),
        "log, counted": (lambda p: table(p / "a.csv", ["loggingTime(txt)", "loggingSample(N)", "accelerometerTimestamp_sinceReboot(s)", *(f"accelerometerAcceleration{a}(G)" for a in "XYZ")], iso("+02:00"), [*range(len(T))], T + 9, -ACC / G), 1, False),
        "AndroSensor": (lambda p: table(p / "a.csv", [*andro, "Time since start in ms ", "YYYY-MO-DD HH-MI-SS_SSS"], ACC, GRAVITY, MOVED, GYR, [round(1000 * t) for t in T], ["2024-05-01 10-11-12_345"] * len(T), mark=";"), 1, True),
        "AndroSensor, commas": (lambda p: table(p / "a.csv", [*andro, "TIME SINCE START (ms)", "DATE (YYYY-MO-DD HH-MI-SS_SSS)"], ACC, GRAVITY, MOVED, GYR, [round(1000 * t) for t in T], ["2024-05-01 10-11-12_345"] * len(T), mark=", "), 1, True),
        "Beiwe": (lambda p: table(p / "accelerometer.csv", ["timestamp", "UTC time", "accuracy", "x", "y", "z"], [START * 1000 + round(1000 * t) for t in T], iso(), ["unknown"] * len(T), ACC), 1, False),
        "Core Motion's names": (lambda p: table(p / "a.csv", ["time_s", "epoch_s", *(f"userAcceleration{a}" for a in "XYZ"), *(f"gravity{a}" for a in "XYZ"), *(f"rotationRate{a} (rad/s)" for a in "XYZ")], T, T + START, -MOVED / G, -GRAVITY / G, GYR), 1, True),
        "Wear OS, nanoseconds": (lambda p: table(p / "a.csv", ["timestamp_ns", *(f"accelerometer_{a} [m/s²]" for a in "xyz"), *(f"gyroscope_{a} [rad/s]" for a in "xyz")], EPOCH_NS, ACC, GYR), 1, True),
        "other, swung round": (lambda p: table(p / "a.csv", ["time (s)", *XYZ_ACC], T, 1.77 * ACC), 1.77, False),
        "other, a label above bare axes": (lambda p: rounded(p / "a.csv", "#walk\ntime[ms]; x-axis[m/s^2]; y-axis[m/s^2]; z-axis[m/s^2]", 1000 * T, ACC, mark=";"), 1, False),
    }  # fmt: skip


def doubtful() -> dict[str, tuple[Write, str]]:
    """Files that say too little or what cannot be: what writes each, and words of the refusal."""
    return {
        "phyphox without g": (lambda p: table(p / "Raw Data.csv", ["Time (s)", *(f"Linear Acceleration {a} (m/s^2)" for a in "xyz")], T, MOVED), "with gravity"),
        "toolbox, linear accelerometer": (lambda p: table(p / "a.csv", ["time", "ax", "ay", "az", "aT"], T, MOVED, np.linalg.norm(MOVED, axis=1)), "with gravity"),
        "logger, acceleration alone": (lambda p: logger(p, {"Accelerometer": MOVED, "Gyroscope": GYR}), "with gravity"),
        "log, user's acceleration alone": (lambda p: table(p / "a.csv", ["loggingTime(txt)", *(f"motionUserAcceleration{a}(G)" for a in "XYZ")], iso(), -MOVED / G), "with gravity"),
        "g called m/s2": (lambda p: table(p / "a.csv", ["Time (s)", *XYZ_ACC], T, ACC / G), "with gravity"),
        "m/s2 called g": (lambda p: table(p / "a.csv", ["time", "gFx", "gFy", "gFz"], T, ACC), "with gravity"),
        "thousandths of g": (lambda p: table(p / "a.csv", ["time (s)", "acc_x", "acc_y", "acc_z"], T, 1000 * ACC / G), "with gravity"),
        "gyroscope without a unit": (lambda p: table(p / "a.csv", ["time (s)", "acc_x", "acc_y", "acc_z", "gyro_x", "gyro_y", "gyro_z"], T, ACC, GYR), "unit"),
        "what ax and gx are": (lambda p: table(p / "a.csv", ["time (s)", "ax", "ay", "az", "gx", "gy", "gz"], T, ACC, GYR), "name it|unit"),
        "degrees called radians": (lambda p: table(p / "a.csv", ["time (s)", *XYZ_ACC, *XYZ_GYR], T, ACC, 90 * np.degrees(GYR)), "faster"),
        "slow degrees called radians": (lambda p: table(p / "a.csv", ["time (s)", *XYZ_ACC, *XYZ_GYR], T, ACC, np.degrees(GYR)), "faster"),
        "radians called degrees": (lambda p: table(p / "a.csv", ["time (s)", *XYZ_ACC, "wx (deg/s)", "wy (deg/s)", "wz (deg/s)"], T, ACC, GYR), "slower"),
        "hard shaking without gravity": (lambda p: table(p / "a.csv", ["time (s)", *XYZ_ACC], T, 5 * MOVED), "with gravity"),
        "magnetometer alone": (lambda p: table(p / "a.csv", ["Time (s)", *(f"Magnetic field {a} (µT)" for a in "xyz")], T, 40 * QUATERNION[:, :3]), "no acceleration"),
        "milliseconds called seconds": (lambda p: table(p / "a.csv", ["Time (s)", *XYZ_ACC], 1000 * T, ACC), "no times of a sensor"),
        "numbers of rows for times": (lambda p: table(p / "a.csv", ["time (s)", *XYZ_ACC], np.arange(len(T)), ACC), "no times of a sensor"),
        "no times": (lambda p: table(p / "a.csv", ["n", *XYZ_ACC], T, ACC), "names a time"),
        "points in thousands": (lambda p: table(p / "a.csv", ["time (s)", *XYZ_ACC], T, [["1.234,5"] * len(T)] * 3, mark=";"), "no number"),
        "two axes": (lambda p: table(p / "a.csv", ["time (s)", *XYZ_ACC[:2], "steps"], T, ACC), "no acceleration"),
        "toolbox, started twice": (lambda p: table(p / "a.csv", ["time", "gFx", "gFy", "gFz"], np.concatenate([T[:300], T[:300] + 0.01]), ACC / G), "times go back"),
        "toolbox, two headers": (lambda p: rounded(p / "a.csv", "time,gFx,gFy,gFz", T, ACC / G, foot="time,gFx,gFy,gFz\n0,0,0,1"), "no number"),
        "toolbox, dates in words": (lambda p: table(p / "a.csv", ["time", "gFx", "gFy", "gFz"], [f"Wednesday 01-May-2024 10-11-{12 + int(t)} AM" for t in T], ACC / G), "no number"),
        "toolbox, gyroscope alone": (lambda p: table(p / "a.csv", ["time", "wx", "wy", "wz"], T, GYR), "no acceleration"),
        "half a day's clock": (lambda p: table(p / "a.csv", ["time", "gFx", "gFy", "gFz"], [f"11:59:{40 + t:06.3f} AM" for t in T.tolist()], ACC / G), "a time is none"),
        "phyphox, French without g": (lambda p: table(p / "Raw Data.csv", ["Temps (s)", *(f"Accélération linéaire {a} (m/s^2)" for a in "xyz")], T, MOVED), "with gravity"),
        "phyphox, linear beside a gyroscope": (lambda p: table(table(p / "Linear Accelerometer.csv", ["Time (s)", *(f"Linear Acceleration {a} (m/s^2)" for a in "xyz")], T, MOVED).parent / "Gyroscope.csv", ["Time (s)", *XYZ_GYR], T, GYR).parent, "with gravity"),
        "logger, one file of acceleration": (lambda p: table(p / "Accelerometer.csv", LOGGER, EPOCH_NS, T, MOVED[:, ::-1]), "with gravity"),
        "logger, gravity alone": (lambda p: logger(p, {"Gravity": GRAVITY}), "with gravity"),
        "logger, turn alone": (lambda p: table(p / "Orientation.csv", [*LOGGER[:2], "qz", "qy", "qx", "qw", "roll", "pitch", "yaw"], EPOCH_NS, T, QUATERNION, GYR), "no acceleration"),
        "log, gravity alone": (lambda p: table(p / "a.csv", ["loggingTime(txt)", *(f"motionGravity{a}(G)" for a in "XYZ")], iso(), -GRAVITY / G), "with gravity"),
        "Core Motion without units": (lambda p: table(p / "a.csv", ["timestamp", *(f"userAcceleration{a}" for a in "XYZ"), *(f"gravity{a}" for a in "XYZ"), *(f"rotationRate{a}" for a in "XYZ")], T, -MOVED / G, -GRAVITY / G, GYR), "unit"),
        "Core Motion, user's alone": (lambda p: table(p / "a.csv", ["timestamp", *(f"userAcceleration{a}" for a in "XYZ")], T, -MOVED / G), "with gravity"),
        "watch, rate without a unit": (lambda p: table(p / "a.csv", ["Timestamp", *(f"Acceleration{a}" for a in "XYZ"), *(f"RotationRate{a}" for a in "XYZ"), "HeartRate"], iso("Z"), ACC / G, GYR, 60 + T), "unit"),
        "turns a minute": (lambda p: table(p / "a.csv", ["time (s)", *XYZ_ACC, *(f"gyro_{a} (rpm)" for a in "xyz")], T, ACC, 9.55 * GYR), "unit"),
        "gravity's direction alone": (lambda p: table(p / "a.csv", ["time (s)", *(f"gravity_{a} (m/s^2)" for a in "xyz")], T, GRAVITY), "with gravity"),
        "m/s2 called g, waved": (lambda p: table(p / "a.csv", ["time", "gFx", "gFy", "gFz"], T, G * np.stack([np.sin(12 * T), np.cos(12 * T), 0 * T + 0.25], axis=1)), "with gravity"),
        "ten times too large": (lambda p: table(p / "a.csv", ["time (s)", "acc_x", "acc_y", "acc_z"], T, 10 * ACC), "with gravity"),
        "too short": (lambda p: table(p / "a.csv", ["time (s)", *XYZ_ACC], T[:50], ACC[:50]), "less than 2 s"),
    }  # fmt: skip


def worn_like_clips(study, folder: Path, patch: int, times: int = 12, **how: object) -> Path:
    """Physics Toolbox's files of Ada and Ben, who wear a phone at a study's patch and move as its clips do."""
    rng = np.random.default_rng(0)
    for number, clip in enumerate(study.clips):
        one = study.recording(number, [patch])
        acc, gyr = (np.tile(values[:, 0], (times, 1)).astype(float) for values in (one.acc, one.gyr))
        file = folder / ("Ada" if number % 2 else "Ben") / f"{clip.activity} {number}.csv"
        names = ["time", "gFx", "gFy", "gFz", "wx", "wy", "wz"]
        table(file, names, np.arange(len(acc)) / one.rate, (acc + rng.normal(scale=0.3, size=acc.shape)) / G, gyr, **how)
    return folder
