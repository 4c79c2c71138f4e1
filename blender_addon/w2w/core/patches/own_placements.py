# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches at the user's own placements: names with the vertex or the position where a sensor is worn."""

from collections.abc import Iterable, Mapping, Sequence
from numbers import Integral
from pathlib import Path

import numpy as np

from ..body.body import Body
from ..csv_tables import read_table
from .naming import place
from .patches import PatchSet, patch_set, sample_patches
from .spots import Spot, vertex_at

OTHERS = 128
"""Other patches of a body on which places are shown: so few that each place is seen."""

FARTHEST_M = 0.05
"""Farthest distance of a position from the skin: a sensor has a case and a strap."""


def patches_at(body: Body, placements: Mapping[str, int | str | Sequence[float]]) -> PatchSet:
    """Patches at placements of your own, named as you name them.

    Parameters
    ----------
    body : Body
    placements : mapping of str to int, str or sequence of 3 floats
        Name of each placement, and the vertex of the body that it is at, its spot as on the tape-measure card
        ("left forearm 85% 50%") or its position (metres, on
        the body at rest; the nearest vertex of the skin is taken).

    Returns
    -------
    PatchSet
        One patch a placement, in their order; `names` are theirs, `regions` those they lie in.

    Raises
    ------
    ValueError
        If there are none, a name is empty or given twice, a vertex is not the body's, a position is
        more than 5 cm from the skin, or two placements are at the same vertex.

    Examples
    --------
    >>> w2w.patches_at(w2w.Body.bundled(), {"ring": 4000}).regions
    ('right index finger',)
    """
    if not isinstance(placements, Mapping):
        raise ValueError(f"placements are given as {{'strap pod': 1234}}, not as {placements!r}")
    vertices = placement_vertices(body, placements)
    return patch_set(body, np.array(list(vertices.values())), tuple(vertices), seed=0)


def with_placements(
    body: Body, patches: PatchSet, placements: Mapping[str, int | str | Sequence[float]]
) -> PatchSet:
    """Patches of a body, and placements of your own, as for `patches_at`, after them.

    The patches keep their numbers and names. A placement at the vertex of one of them is that one, under its
    own name.

    Raises ValueError as `patches_at` does, or if a placement is called as a patch elsewhere is.
    """
    own = placement_vertices(body, placements)
    check_names(own, names_elsewhere(patches, own.values()))
    names, centres = list(patches.names), patches.vertices.tolist()
    for name, vertex in own.items():
        if vertex in centres:
            names[centres.index(vertex)] = name
        else:
            names.append(name)
            centres.append(vertex)
    return patch_set(body, np.array(centres), tuple(names), patches.seed)


def placement_vertices(body: Body, placements: Mapping[str, int | str | Sequence[float]]) -> dict[str, int]:
    """Vertex of the skin that each placement is at, by its name; parameters and errors as `patches_at`."""
    if not placements:
        raise ValueError("no placement is given: name at least one")
    names = check_names(placements)
    vertices = [_vertex(body, *each) for each in zip(names, placements.values(), strict=True)]
    check_apart(names, vertices)
    return dict(zip(names, vertices, strict=True))


def check_names(given: Iterable[str], taken: Iterable[str] = ()) -> tuple[str, ...]:
    """Names of placements with single spaces, each its own and none of those taken.

    Raises ValueError if one is empty, given twice or taken.
    """
    names: dict[str, str] = {}
    patches = {name.lower() for name in taken}
    for words in given:
        name = " ".join(str(words).split())
        if not name:
            raise ValueError("a placement has an empty name: call it by where it is worn")
        if name.lower() in names:
            raise ValueError(f"two placements are called '{name}' (case and spaces do not count)")
        if name.lower() in patches:
            raise ValueError(f"a patch of the body is called '{name}' already: name your placement otherwise")
        names[name.lower()] = name
    return tuple(names.values())


def check_apart(names: Sequence[str], vertices: Sequence[int]) -> None:
    """Refuse two placements at one vertex."""
    at: dict[int, str] = {}
    for name, vertex in zip(names, vertices, strict=True):
        if vertex in at:
            raise ValueError(
                f"'{at[vertex]}' and '{name}' are both at vertex {vertex}: leave one of them out"
            )
        at[vertex] = name


def names_elsewhere(patches: PatchSet, vertices: Iterable[int]) -> list[str]:
    """Names of the patches at other vertices than these: placements must not reuse these names."""
    at, pairs = set(vertices), zip(patches.names, patches.vertices.tolist(), strict=True)
    return [name for name, vertex in pairs if vertex not in at]


def read_placements(path: str | Path) -> dict[str, int | str | tuple[float, float, float]]:
    """Read placements from a csv file: ``name`` and either ``vertex``, ``spot`` or ``x``, ``y``, ``z``.

    A spot is written as on the tape-measure card: left forearm 85% 50%.

    Raises ValueError, naming the line, if the file cannot be read or is not such a table.
    """
    placements: dict[str, int | str | tuple[float, float, float]] = {}
    for line, row in read_table(path, ("name",), ("vertex", "spot", "x", "y", "z")).rows:
        if row["name"] in placements:
            raise ValueError(f"{path}, line {line}: '{row['name']}' stands there a second time")
        position = (row["x"], row["y"], row["z"])
        wrong = (
            f"'{row['name']}' needs the number of a vertex, a spot, or x, y and z in metres, not "
            f"'{row['vertex'] or ', '.join(position)}'"
        )
        try:
            if row["spot"]:
                placements[row["name"]] = str(Spot.parse(row["spot"]))
            elif row["vertex"]:
                placements[row["name"]] = int(row["vertex"])
            else:
                x, y, z = map(float, position)
                placements[row["name"]] = (x, y, z)
        except ValueError as error:
            raise ValueError(f"{path}, line {line}: {error if row['spot'] else wrong}") from None
    if not placements:
        raise ValueError(f"{path} names no placement")
    return placements


def _vertex(body: Body, name: str, where: int | str | Sequence[float]) -> int:
    """The vertex of the skin at a vertex number or nearest to a position."""
    if isinstance(where, str):
        return vertex_at(body, Spot.parse(where))
    skin = np.unique(body.faces)
    if isinstance(where, Integral) and not isinstance(where, bool):
        if where not in skin:
            raise ValueError(
                f"'{name}' is at vertex {where}, which the skin of this body does not have: its vertices are "
                f"numbered from {skin[0]} to {skin[-1]}"
            )
        return int(where)
    try:
        position = np.asarray(where, dtype=np.float64)
    except (TypeError, ValueError):
        position = np.empty(0)
    if position.shape != (3,) or not np.isfinite(position).all():
        raise ValueError(
            f"'{name}' needs the number of a vertex or a position (x, y, z) in metres, not {where!r}"
        )
    away = np.linalg.norm(body.vertices[skin] - position, axis=1)
    if away.min() > FARTHEST_M:
        raise ValueError(
            f"'{name}' lies {100 * away.min():.1f} cm from the skin, and at most {100 * FARTHEST_M:.0f} cm "
            "are allowed: positions are in metres on the body at rest, z up, the soles at z = 0"
        )
    return int(skin[away.argmin()])


def shown_on(names: Sequence[str], scores: np.ndarray) -> tuple[Body, PatchSet, np.ndarray]:
    """W2W's body with patches at places by name and others, and the scores (N,) of the places, else NaN.

    Raises ValueError if nothing on a body is called one of them.
    """
    body = Body.bundled()
    at = [place(name, body) for name in names]
    check_apart(names, at)
    rest = np.setdiff1d(sample_patches(body, OTHERS).vertices, at)
    patches = patch_set(body, np.concatenate([at, rest]), (), seed=0)
    return body, patches, np.concatenate([scores, np.full(len(rest), np.nan)])
