# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's options from a file: TOML with the keys of `config.json`, or the `config.json` of a run itself."""

import inspect
import json
import tomllib
from collections.abc import Callable, Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from textwrap import wrap
from typing import Any, get_args

import typer

from ..core.parameters import parameters_of
from ..core.study.config import StudyConfig
from ..core.wording import clean, restated

PATHS = {each.path: name for name, each in parameters_of(StudyConfig).items()}
PATHS[("windows", "stride_s")] = "stride"
"""Option of each key of a configuration, by the tables that lead to it."""

NO_OPTIONS = ("config", "shard")
"""Options that no file holds: which file, and which part of the clips."""

OF_MACHINES = ("workers",)
"""Options whose default is the machine's."""

FOLLOWS = "sensor_model"
"""Key of a `config.json` that follows from others."""


def take_options(ctx: typer.Context, path: Path | None) -> Path | None:
    """Give a command the options of a file; those on the command line come first."""
    if path is not None:
        types = {each.name: each.type for each in ctx.command.params if each.name not in NO_OPTIONS}
        is_path = {str(name): kind.name == "path" for name, kind in types.items()}
        with restated("", (ValueError, OSError), typer.BadParameter):
            ctx.default_map = options_in(path, is_path)
    return path


def options_in(path: Path, is_path: Mapping[str, bool]) -> dict[str, Any]:
    """The options in a file by name; those that are paths (`is_path`) are relative to the file's folder.

    Raises ValueError if a key is no option; the message names what comes closest.
    """
    defaults = dict(_flat(StudyConfig().as_dict()))
    found: dict[str, Any] = {}
    for where, value in _flat(_content(path)):
        name = PATHS.get(where, where[0].replace("-", "_") if len(where) == 1 else "")
        if name not in is_path:
            if where[0] == FOLLOWS or value is None or defaults.get(where, ()) == value:
                continue
            raise ValueError(_unknown(path, ".".join(where), is_path))
        if value in (None, []):
            continue
        if isinstance(value, list) and not all(isinstance(each, str) for each in value):
            raise ValueError(f"{clean(path)}: '{'.'.join(where)}' is given as the path of a csv")
        if is_path[name] and not isinstance(value, list):
            value = str(path.parent / str(value))
        found[name] = ",".join(value) if isinstance(value, list) and name != "bone_map" else value
    return found


def _content(path: Path) -> Mapping[str, Any]:
    wrong = f"{clean(path)} cannot be read as options:"
    with restated(lambda error: f"{wrong} {getattr(error, 'strerror', error)}", (OSError, ValueError)):
        text = path.read_text(encoding="utf-8")
        if path.suffix.lower() != ".json":
            return tomllib.loads(text)
        content = json.loads(text)
        content = content.get("parameters", content) if isinstance(content, dict) else None
        if not isinstance(content, dict):
            raise ValueError("it is no object of options")
        return content


def _flat(content: Mapping[str, Any], where: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Values of nested tables, each with the keys that lead to it."""
    for key, value in content.items():
        if isinstance(value, Mapping):
            yield from _flat(value, (*where, key))
        else:
            yield (*where, key), value


def _unknown(path: Path, key: str, names: Mapping[str, bool]) -> str:
    known = [*(".".join(where) for where, name in PATHS.items() if name in names), *names]
    close = get_close_matches(key, dict.fromkeys(known), n=3, cutoff=0.5)
    hint = f"; did you mean {', '.join(close)}?" if close else ""
    return f"{clean(path)}: there is no '{key}'{hint}"


def template(command: Callable[..., None]) -> str:
    """A file with every option of a command, each with its help and default; what has none is a comment."""
    where_of = {name: where for where, name in PATHS.items()}
    tables: dict[tuple[str, ...], list[str]] = {(): []}
    for name, parameter in inspect.signature(command).parameters.items():
        if name in NO_OPTIONS:
            continue
        *table, key = where_of.get(name, (name,))
        (about,) = get_args(parameter.annotation)[1:]
        default = parameter.default
        given = default not in (None, "", inspect.Parameter.empty) and name not in OF_MACHINES
        text = '""' if default == "" or Path in get_args(get_args(parameter.annotation)[0]) else ""
        lines = tables.setdefault(tuple(table), [])
        lines += [f"# {line}" for line in wrap(" ".join(about.help.split()), 98)]
        lines += [f"{key} = {json.dumps(default)}" if given else f"# {key} = {text}".rstrip(), ""]
    parts = ["# A run's options: w2w run --config study.toml. Paths are relative to this file's folder.", ""]
    for where, lines in tables.items():
        parts += [f"[{'.'.join(where)}]", *lines] if where else lines
    return "\n".join(parts)
