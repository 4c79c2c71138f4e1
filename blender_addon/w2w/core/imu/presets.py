# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensor models of real parts; `sensors.json` has their figures and the datasheet each comes from.

How a datasheet is read there:

- A "typical" deviation of Bosch or ST is one standard deviation, as both makers define it; a tolerance of
  InvenSense and any minimum or maximum is three.
- Cross-axis sensitivity becomes lean between the axes, its arcsine.
- Ranges are the ones common in activity recognition, the resolution that of the part's word at that range.
- What a datasheet leaves out stays switched off. None of the chips' datasheets prints a bias instability.

`sources` notes which figures were read in the document's text ("read"), which agree with the register tables
that public drivers of the part print ("in drivers"), which were found as others copied them from the named
table ("copied"), and which are quoted from memory of the document ("recalled") and deserve a second look
before work that leans on them.
"""

from ..body.body import template
from .sensor import SensorModel
from .sensor_fields import sensor_with

DEFAULT_SENSOR = "bmi270"
"""A current consumer part."""


def _bundled() -> dict[str, SensorModel]:
    found: dict[str, SensorModel] = {}
    for name, sensor in template("sensors.json").items():
        base = found[sensor["like"]] if "like" in sensor else SensorModel.ideal()
        figures = {field: value for field, value in sensor.items() if field != "sources"}
        found[name] = sensor_with(base, figures, name)
    return found


PRESETS = _bundled()
"""All presets by name."""


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
    for known, model in PRESETS.items():
        if _plain(known) == _plain(name):
            return model
    raise ValueError(f"there is no sensor preset {name!r}; choose one of {', '.join(PRESETS)}")


def _plain(name: str) -> str:
    return "".join(character for character in name.lower() if character.isalnum())
