# SPDX-License-Identifier: GPL-3.0-or-later
"""What options mean that hold words: the bodies that a study is run on, and wishes for sensors."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from w2w.core.body.body import Body
from w2w.core.body.shapes import MORPHOLOGIES, shaped
from w2w.core.files import load_arrays, reserved
from w2w.core.selection.constraints import Constraints, read_costs
from w2w.scene.output import quiet_output

from .needs_blender import needs_blender

GENDERS = {"neutral": 0.0, "female": -1.0, "male": 1.0}
SHAPE_PARAMETERS = ("height", "weight", "muscle", "age", "arms", "legs")

BETAS = re.compile(r"(?P<file>.*\S)\s+betas=(?P<betas>\S+)")

EXAMPLE = "'female', 'male height=1.9 weight=95' or the path of an SMPL file"


def parse_bodies(text: str) -> list[tuple[str, Body]]:
    """Bodies from what a person writes: descriptions or files, separated by commas.

    Parameters
    ----------
    text : str
        Such as ``"neutral, female height=1.55, male"``, ``"SMPL_NEUTRAL.npz"`` or
        ``"SMPL_NEUTRAL.npz betas=walking.npz"``.

    Returns
    -------
    list of (str, Body)
        A name that can be a folder's, and the body.

    Raises
    ------
    ValueError
        If a description is not understood or a shape cannot be reached.
    """
    parts = [part.strip() for part in text.split(",") if part.strip()]
    if not parts:
        raise ValueError(f"give at least one body, such as {EXAMPLE}")
    bodies = [(_folder_name(part), _body(part)) for part in parts]
    if len({name.lower() for name, _ in bodies}) < len(bodies):
        raise ValueError(f"two of the bodies are the same: {text}")
    return bodies


def _body(text: str) -> Body:
    words = text.split()
    if text in MORPHOLOGIES:
        return shaped(Body.bundled(), **MORPHOLOGIES[text]) if MORPHOLOGIES[text] else Body.bundled()
    if words[0] in GENDERS:
        return _shaped(words)
    with_betas = BETAS.fullmatch(text)
    file, betas = (with_betas["file"], _betas(with_betas["betas"])) if with_betas else (text, None)
    if Path(file).suffix:
        with needs_blender():
            from w2w.scene.adopt import adopt_file

        with quiet_output():
            return adopt_file(file, betas)
    raise ValueError(
        f"'{text}' is no body that W2W knows: write {EXAMPLE}, or one of {', '.join(MORPHOLOGIES)}"
    )


def _folder_name(text: str) -> str:
    with_betas = BETAS.fullmatch(text)
    file, betas = (
        (with_betas["file"], " betas " + Path(with_betas["betas"]).name) if with_betas else (text, "")
    )
    name = re.sub(r"[^0-9A-Za-z.]+", "_", Path(file).name + betas).rstrip(".")
    return f"body_{name}" if reserved(name) or not name else name


def _betas(text: str) -> np.ndarray:
    """Shape coefficients, from numbers joined by colons or from the npz of a motion."""
    try:
        if text.lower().endswith(".npz"):
            betas = load_arrays(text, ("betas",), "gives no betas")["betas"]
            return np.atleast_1d(betas.squeeze()).astype(np.float64)
        return np.array([float(number) for number in text.split(":")])
    except (OSError, KeyError, ValueError) as error:
        raise ValueError(
            f"betas={text}: {error}; write numbers such as betas=1.2:0:-0.5, or an npz that holds 'betas'"
        ) from error


def _shaped(words: list[str]) -> Body:
    given = {}
    for word in words[1:]:
        name, _, value = word.partition("=")
        try:
            given[name] = float(value)
        except ValueError:
            raise ValueError(f"'{word}' is not understood: write a shape as {EXAMPLE}") from None
        if name not in SHAPE_PARAMETERS:
            raise ValueError(f"'{name}' is no shape parameter; there are {', '.join(SHAPE_PARAMETERS)}")
    return shaped(Body.bundled(), gender=GENDERS[words[0]], **given)


def parse_wishes(only: str, forbid: str, must: str, costs: Path | None) -> Constraints:
    """The options as `Constraints`.

    Raises
    ------
    ValueError, OSError
        If a cost is wrong or its table cannot be read.
    """
    return Constraints(words(only), words(forbid), words(must), read_costs(costs) if costs else ())


def wishes_over(
    run: Constraints, only: str | None, forbid: str | None, must: str | None, costs: Path | None
) -> Constraints:
    """A run's wishes, with those options in their place that are given.

    Raises
    ------
    ValueError, OSError
        As `parse_wishes`.
    """
    given = {"only": only, "forbid": forbid, "must": must}
    changed = {name: words(text) for name, text in given.items() if text is not None}
    return replace(run, **changed, **({"costs": read_costs(costs)} if costs else {}))


def words(text: str) -> tuple[str, ...]:
    """What a person lists, separated by commas."""
    return tuple(part.strip() for part in text.split(",") if part.strip())
