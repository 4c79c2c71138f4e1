# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensor models of real parts, with the datasheet each figure comes from.

How a datasheet is read here:

- A "typical" deviation of Bosch or ST is one standard deviation, as both makers define it; a tolerance of
  InvenSense and any minimum or maximum is three.
- Cross-axis sensitivity becomes lean between the axes.
- Ranges are the ones common in activity recognition, the resolution that of the part's word at that range.
- What a datasheet leaves out stays switched off. None of the chips' datasheets prints a bias instability.

Each model notes which figures were read in the document's text ("read"), which agree with the register tables
that public drivers of the part print ("in drivers"), which were found as others copied them from the named
table ("copied"), and which are quoted from memory of the document ("recalled") and deserve a second look
before work that leans on them.
"""

from __future__ import annotations

import numpy as np

from .sensor import SensorModel, Triad

G = 9.80665
MG = G / 1e3
UG = G / 1e6
DPS = np.pi / 180
PER_HOUR = 1 / 3600

DEFAULT_SENSOR = "bmi270"
"""A current consumer part."""


def preset(name: str) -> SensorModel:
    """Sensor model of a real part.

    Parameters
    ----------
    name : str
        One of `PRESETS`; case, spaces, hyphens and underscores do not matter.

    Raises
    ------
    ValueError
        If there is no such preset; the message lists them.
    """
    if not isinstance(name, str):
        raise ValueError(
            f"a sensor is a preset's name or a SensorModel (read_sensor reads a file), not {name!r}"
        )
    wanted = _plain(name)
    for known, model in PRESETS.items():
        if _plain(known) == wanted:
            return model
    raise ValueError(f"there is no sensor preset {name!r}; choose one of {', '.join(PRESETS)}")


def _plain(name: str) -> str:
    return "".join(character for character in name.lower() if character.isalnum())


def _lean_deg(cross_axis: float) -> float:
    """Lean between axes that gives a cross-axis sensitivity."""
    return float(np.degrees(np.arcsin(cross_axis)))


def _per_count(full_scale: float) -> float:
    """Step of a 16-bit word."""
    return full_scale / 2**15


IDEAL = SensorModel.ideal()

MPU_6050 = SensorModel(
    name="mpu-6050",
    # InvenSense PS-MPU-6000A-00 rev. 3.4, 6.1 and 6.2, read: noise, offsets, tolerances, cross-axis and
    # linear acceleration sensitivity. RM-MPU-6000A-00 rev. 4.2, register 26, DLPF_CFG 3, in drivers: 44
    # and 42 Hz.
    accelerometer=Triad(
        full_scale=8 * G,
        resolution=_per_count(8 * G),
        noise_density=400 * UG,
        turn_on_bias=60 / 3 * MG,
        scale_error=0.03 / 3,
        nonorthogonality_deg=_lean_deg(0.02 / 3),
        lowpass_hz=44.0,
    ),
    gyroscope=Triad(
        full_scale=2000 * DPS,
        resolution=_per_count(2000 * DPS),
        noise_density=0.005 * DPS,
        turn_on_bias=20 / 3 * DPS,
        scale_error=0.03 / 3,
        nonorthogonality_deg=_lean_deg(0.02 / 3),
        lowpass_hz=42.0,
    ),
    g_sensitivity=0.1 * DPS / G,
)

MPU_9250 = SensorModel(
    name="mpu-9250",
    # InvenSense PS-MPU-9250A-01 rev. 1.0, 3.1 and 3.2, read: all but the filters. RM-MPU-9250A-00 rev.
    # 1.4, registers 26 and 29, DLPF_CFG 3, in drivers: 44.8 and 41 Hz.
    accelerometer=Triad(
        full_scale=8 * G,
        resolution=_per_count(8 * G),
        noise_density=300 * UG,
        turn_on_bias=65 / 3 * MG,
        scale_error=0.03 / 3,
        nonorthogonality_deg=_lean_deg(0.02 / 3),
        lowpass_hz=44.8,
    ),
    gyroscope=Triad(
        full_scale=2000 * DPS,
        resolution=_per_count(2000 * DPS),
        noise_density=0.01 * DPS,
        turn_on_bias=5 / 3 * DPS,
        scale_error=0.03 / 3,
        nonorthogonality_deg=_lean_deg(0.02 / 3),
        lowpass_hz=41.0,
    ),
)

BMI160 = SensorModel(
    name="bmi160",
    # Bosch BST-BMI160-DS000-07 rev. 0.8. 1.1 tables 2 and 3, recalled: noise, zero-g offset,
    # sensitivity and cross-axis; zero-rate offset read in Bosch's forum, thread 9060. 2.4.1, rev. 0.7,
    # read: the accelerometer's bandwidth (5.06 Hz at 50 Hz, fourfold oversampled). Normal mode, recalled:
    # the gyroscope's.
    accelerometer=Triad(
        full_scale=8 * G,
        resolution=_per_count(8 * G),
        noise_density=180 * UG,
        turn_on_bias=40 * MG,
        scale_error=0.005,
        nonorthogonality_deg=_lean_deg(0.01),
        lowpass_of_rate=0.405,
    ),
    gyroscope=Triad(
        full_scale=2000 * DPS,
        resolution=_per_count(2000 * DPS),
        noise_density=0.007 * DPS,
        turn_on_bias=3 * DPS,
        scale_error=0.03 / 3,
        nonorthogonality_deg=_lean_deg(0.02),
        lowpass_of_rate=0.399,
    ),
)

BMI270 = SensorModel(
    name="bmi270",
    # Bosch BST-BMI270-DS000-07 rev. 1.5. Page 1, read: noise of both. 1.2, zero-rate offset read in
    # Bosch's forum, thread 9060; copied: zero-g offset, sensitivity (the gyroscope's before its own
    # retrimming, which brings it to 0.4 %). 4.6, normal mode, recalled: bandwidths.
    accelerometer=Triad(
        full_scale=8 * G,
        resolution=_per_count(8 * G),
        noise_density=160 * UG,
        turn_on_bias=20 * MG,
        scale_error=0.004,
        lowpass_of_rate=0.405,
    ),
    gyroscope=Triad(
        full_scale=2000 * DPS,
        resolution=_per_count(2000 * DPS),
        noise_density=0.007 * DPS,
        turn_on_bias=0.5 * DPS,
        scale_error=0.02 / 3,
        lowpass_of_rate=0.399,
    ),
)

LSM6DSO = SensorModel(
    name="lsm6dso",
    # ST DS12140 rev. 3, table 2, copied: noise in high-performance mode (80 ug/sqrt(Hz) at 8 g),
    # offsets, sensitivity and its tolerance. Rev. 2, notes 6, 8, 13 and 16, read: noise does not depend
    # on the rate; 70 mdps. Figure 17, copied: the accelerometer's bandwidth is half the rate. Table 18:
    # the gyroscope's, 4.2 Hz at 12.5 Hz copied, 33 Hz at 104 Hz recalled.
    accelerometer=Triad(
        full_scale=8 * G,
        resolution=0.244 * MG,
        noise_density=80 * UG,
        turn_on_bias=20 * MG,
        scale_error=0.01,
        lowpass_of_rate=0.5,
    ),
    gyroscope=Triad(
        full_scale=2000 * DPS,
        resolution=0.070 * DPS,
        noise_density=0.0038 * DPS,
        turn_on_bias=1 * DPS,
        scale_error=0.01,
        lowpass_of_rate=0.32,
    ),
)

ICM_20948 = SensorModel(
    name="icm-20948",
    # TDK InvenSense DS-000189 rev. 1.3. Table 2, read: the accelerometer. Table 1, copied: the
    # gyroscope's offset and noise; recalled: its tolerance and cross-axis. Tables 16 and 18, DLPFCFG 3,
    # in drivers: filters.
    accelerometer=Triad(
        full_scale=8 * G,
        resolution=_per_count(8 * G),
        noise_density=230 * UG,
        turn_on_bias=50 / 3 * MG,
        scale_error=0.005 / 3,
        nonorthogonality_deg=_lean_deg(0.02 / 3),
        lowpass_hz=50.4,
    ),
    gyroscope=Triad(
        full_scale=2000 * DPS,
        resolution=_per_count(2000 * DPS),
        noise_density=0.015 * DPS,
        turn_on_bias=5 / 3 * DPS,
        scale_error=0.015 / 3,
        nonorthogonality_deg=_lean_deg(0.02 / 3),
        lowpass_hz=51.2,
    ),
)

MTW_AWINDA = SensorModel(
    name="xsens mtw awinda",
    # Paulich, Schepers, Rudigkeit and Bellusci 2018, "Xsens MTw Awinda",
    # doi:10.13140/RG.2.2.23576.49929, table of the components, recalled: ranges, noise, bias stability,
    # alignment. Calibrated at the factory for bias, gain, misalignment and g sensitivity (MW0502P rev.
    # L, read). Strapdown integration at 1 kHz before the radio stands for a filter: no bandwidth below
    # half the output rate.
    accelerometer=Triad(
        full_scale=160.0,
        noise_density=200 * UG,
        bias_instability=0.1 * MG,
        misalignment_deg=0.1,
    ),
    gyroscope=Triad(
        full_scale=2000 * DPS,
        noise_density=0.01 * DPS,
        bias_instability=10 * PER_HOUR * DPS,
        misalignment_deg=0.1,
    ),
)

PHONE = SensorModel(
    name="phone",
    # A class, not a part: the chip figures of the BMI160 and LSM6DSO generations, the gyroscope
    # calibrated by the operating system, time stamps by software. Kos, Tomazic and Umek 2016,
    # doi:10.3390/s16040477, measured 116 phones and found models to differ by several times.
    accelerometer=Triad(
        full_scale=8 * G,
        resolution=_per_count(8 * G),
        noise_density=180 * UG,
        turn_on_bias=30 * MG,
        scale_error=0.005,
        nonorthogonality_deg=0.5,
        lowpass_of_rate=0.4,
    ),
    gyroscope=Triad(
        full_scale=1000 * DPS,
        resolution=_per_count(1000 * DPS),
        noise_density=0.008 * DPS,
        turn_on_bias=0.2 * DPS,
        scale_error=0.01,
        nonorthogonality_deg=0.5,
        lowpass_of_rate=0.4,
    ),
    jitter_s=0.001,
    mounting_turn_deg=10.0,
    mounting_shift_m=0.02,
)

WATCH = SensorModel(
    name="watch",
    # A class, not a part: the BMI270 in a case on a strap that turns about the wrist and gives a
    # little, its packets sent over a radio that loses some. The strap's figures are plausible, not
    # measured.
    accelerometer=BMI270.accelerometer,
    gyroscope=BMI270.gyroscope,
    jitter_s=0.0005,
    drop_fraction=0.002,
    drop_duration_s=0.05,
    mounting_turn_deg=8.0,
    mounting_shift_m=0.005,
    soft_tissue_hz=15.0,
    soft_tissue_damping=0.4,
    soft_tissue_gain=0.5,
)

PAPER = SensorModel(
    name="paper",
    # Ray, Zhou and Lukowicz 2025, doi:10.48550/arXiv.2507.05532, name three errors of their virtual sensors:
    # noise, drift and a fixed misalignment. The figures are W2W's: noise and bias stability of a worn
    # research part, those of the MTw above; a random walk that moves the bias by as much in about a minute
    # and a half; 5 degrees, about how well a strap is aligned with a limb by eye (plausible, not measured).
    accelerometer=Triad(
        noise_density=MTW_AWINDA.accelerometer.noise_density,
        bias_instability=MTW_AWINDA.accelerometer.bias_instability,
        random_walk=0.01 * MG,
    ),
    gyroscope=Triad(
        noise_density=MTW_AWINDA.gyroscope.noise_density,
        bias_instability=MTW_AWINDA.gyroscope.bias_instability,
        random_walk=1 * PER_HOUR * DPS,
    ),
    fixed_misalignment_deg=5.0,
)

PRESETS: dict[str, SensorModel] = {
    model.name: model
    for model in (
        IDEAL,
        BMI270,
        BMI160,
        LSM6DSO,
        ICM_20948,
        MPU_9250,
        MPU_6050,
        MTW_AWINDA,
        PHONE,
        WATCH,
        PAPER,
    )
}
"""All presets by name."""
