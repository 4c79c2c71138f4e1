# SPDX-License-Identifier: GPL-3.0-or-later
"""A group of commands that imports a command when it is called, and for its help reads but one line of it."""

import ast
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

GROUP = "w2w.command"
"""Entry points by which installed packages add commands, as the studies do: ``name = "module:function"``."""


class LazyGroup(TyperGroup):
    """Commands of entry points: those of `OWN`, then W2W's others, and other packages' under their names.

    A function becomes a command, a `typer.Typer` a group.
    """

    OWN: tuple[EntryPoint, ...] = ()

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        others = entry_points(group=GROUP)
        self.points = {point.name: point for point in (*self.OWN, *others)}
        self.commands: dict[str, Any] = dict.fromkeys(self.points)  # typer suggests one of them
        self._listing = False

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ARG002 - typer's own arguments
        if cmd_name not in self.points or self.commands[cmd_name]:
            return self.commands.get(cmd_name)
        point = self.points[cmd_name]
        foreign = point.dist and point.module.partition(".")[0] != __package__.partition(".")[0]
        panel = point.dist.name if foreign else None
        if self._listing:
            return TyperCommand(cmd_name, help=first_line(point), rich_help_panel=panel)
        self.commands[cmd_name] = _loaded(point, panel)
        return self.commands[cmd_name]

    def format_help(self, ctx: Any, formatter: Any) -> None:
        self._listing = True
        try:
            super().format_help(ctx, formatter)
        finally:
            self._listing = False


def _loaded(point: EntryPoint, panel: str | None) -> Any:
    what = getattr(import_module(point.module), point.attr)
    app = typer.Typer(add_completion=False, rich_markup_mode="markdown")
    app.callback()(lambda: None)  # so that it is a group, even of one command
    if isinstance(what, typer.Typer):
        app.add_typer(what, name=point.name, rich_help_panel=panel)
    else:
        app.command(point.name, rich_help_panel=panel)(what)
    return typer.main.get_group(app).commands[point.name]


def first_line(point: EntryPoint) -> str:
    """The first line of a command's help, read from its source.

    That is its function's docstring or, of a group, the `help` of its `typer.Typer`. "" if its module is not
    there.
    """
    spec = find_spec(point.module)
    if spec is None or spec.origin is None:
        return ""
    for made in ast.parse(Path(spec.origin).read_bytes()).body:
        if isinstance(made, ast.FunctionDef) and made.name == point.attr:
            return (ast.get_docstring(made) or "").partition("\n")[0]
        if isinstance(made, ast.Assign) and ast.unparse(made.targets[0]) == point.attr:
            given = {word.arg: word.value for word in getattr(made.value, "keywords", ())}
            return ast.literal_eval(given["help"]) if "help" in given else ""
    return ""
