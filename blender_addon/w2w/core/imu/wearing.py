# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor model in words: its errors, how it is worn, and which of straps and tissue are in its signals."""

from ..wording import join_words
from .sensor import SensorModel


def wearing_sentences(model: SensorModel) -> str:
    """How much of the way a sensor is worn its signals contain, and how much they do not.

    Examples
    --------
    >>> wearing_sentences(SensorModel.ideal())
    'Loose straps, soft tissue and clothes are not in it.'
    """
    held, missing = [], []
    if model.mounting_turn_deg or model.mounting_shift_m:
        off = f"{model.mounting_turn_deg:g}° and {1000 * model.mounting_shift_m:g} mm"
        held.append(f"sits {off} off its place, anew in every clip (one standard deviation)")
    else:
        missing.append("loose straps")
    if model.fixed_misalignment_deg:
        held.append(f"is turned by {model.fixed_misalignment_deg:g}° for good (one standard deviation)")
    if any(model.worn_turn_deg):
        held.append("is turned as the sensor was that it was calibrated with")
    if model.soft_tissue_hz:
        share = f"{model.soft_tissue_gain:.0%}".replace("%", " %")
        held.append(f"rides on soft tissue ({model.soft_tissue_hz:g} Hz, {share} of its motion)")
    else:
        missing.append("soft tissue")
    if model.drop_fraction:
        held.append(f"loses {100 * model.drop_fraction:g} % of its samples")
    missing.append("clothes")
    lacks = f"{join_words(missing).capitalize()} are not in it."
    return f"It {join_words(held)}. {lacks}" if held else lacks
