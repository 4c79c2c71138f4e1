# SPDX-License-Identifier: GPL-3.0-or-later
"""Every command that a document quotes exists, with the options quoted beside it."""

import argparse
import re
import shlex
import sys
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest
import typer

from w2w.headless.app import APP

ROOT = Path(__file__).parents[1]
PLACES = ("*.md", "docs/**/*.md", "benchmarks/*.md", "tests/*/*.md")
DOCUMENTS = [path for place in PLACES for path in ROOT.glob(place) if path.name != "CHANGELOG.md"]
QUOTED = re.compile(
    r"^```sh\n(.*?)^```|`([^`]+)`|<!--\s*(?:check|figures):(.*?)-->", re.DOTALL | re.MULTILINE
)
STARTS = {
    r"(?:\.venv/bin/|blender --command )?w2w ": "",
    r"(?:blender .*|python )headless/w2w\.py -- ": "",
    r"(?:blender .*|python )headless/run\.py -- ": "run ",
}
PROGRAM = re.compile(r"python (?:-m ((?:benchmarks|tests|w2w_studies)\.[\w.]*)|(benchmarks)/(\w+)\.py)(.*)")
FURTHER = re.compile(r"\s(?:[|;<>]|&&|#\s).*")
"""Pipes, further commands and a comment."""


def quoted(text):
    """The commands of a document, a line each."""
    for paragraph in re.split(r"\n{2,}", text):
        for block, inline, check in QUOTED.findall(paragraph):
            lines = block.replace("\\\n", " ").splitlines() or [" ".join((inline or check).split())]
            yield from (FURTHER.sub("", line).translate({ord("["): " ", ord("]"): " "}) for line in lines)


def w2w_commands():
    for path in DOCUMENTS:
        for line in quoted(path.read_text(encoding="utf-8")):
            for start, command in STARTS.items():
                if found := re.match(start, line):
                    yield pytest.param(command + line[found.end() :], id=f"{path.name}: {line[:70]}")


def programs():
    for path in DOCUMENTS:
        for line in quoted(path.read_text(encoding="utf-8")):
            if found := PROGRAM.match(line):
                module, folder, stem, options = found.groups()
                yield pytest.param(module or f"{folder}.{stem}", options, id=f"{path.name}: {line[:70]}")


def options_in(words):
    return {word.partition("=")[0] for word in words if re.match(r"--?[a-z]", word)}


def unknown(command, words):
    """Options that neither the command nor the ones that lead to it have; raises KeyError for no command."""
    known = {"--help"} | {option for one in command.params for option in one.opts + one.secondary_opts}
    if not hasattr(command, "commands") or not words or words[0].startswith("-"):
        return options_in(words) - known
    found = command.get_command(None, words[0])
    if not found:
        raise KeyError(words[0])
    return unknown(found, words[1:]) - known


@cache
def command_line():
    return typer.main.get_command(APP)


@pytest.mark.parametrize("line", list(w2w_commands()))
def test_the_command_line_has_what_documents_quote(line):
    assert not unknown(command_line(), shlex.split(line))


def test_a_command_or_an_option_that_is_gone_is_found():
    app = command_line()
    assert unknown(app, ["study", "rehab", "--out", "OUT", "--gone"]) == {"--gone"}
    assert unknown(app, ["run", "CLIPS", "--sensor", "watch", "--leave-one-out"]) == {"--leave-one-out"}
    with pytest.raises(KeyError):
        unknown(app, ["study", "gone"])


class _ReachedError(Exception):
    pass


@pytest.mark.parametrize(("module", "options"), list(programs()))
def test_programs_have_what_documents_quote(module, options, monkeypatch):
    pytest.importorskip("bpy")
    wanted = options_in(shlex.split(options))
    main = import_module(module).main

    def parse(parser, *_):
        subcommands = [one for one in parser._actions if isinstance(one, argparse._SubParsersAction)]
        parsers = [parser, *(two for one in subcommands for two in one.choices.values())]
        raise _ReachedError(wanted.difference(*(one._option_string_actions for one in parsers)))

    monkeypatch.setattr(argparse.ArgumentParser, "parse_args", parse)
    monkeypatch.setattr(sys, "argv", [module])
    if wanted:
        with pytest.raises(_ReachedError) as known:
            main()
        assert known.value.args == (set(),)
