# SPDX-License-Identifier: GPL-3.0-or-later
"""Which doors of W2W know a parameter that is one number: `python -m tests.doors trial_number` prints them.

Each is tried with 2.5 in its place, as a user would.
"""

import asyncio
import json
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
import numpy as np

import w2w
from tests.command_line import cli
from tests.ui.test_panels import draw, view_of_panels
from w2w.core.body.body import N_JOINTS
from w2w.core.study.config import StudyConfig
from w2w.headless.commands import run
from w2w.headless.commands.init import template
from w2w.ui.panels.sensor import W2W_PT_sensor
from w2w.ui.study.state import config_of
from w2w.web.shown import Pages
from w2w.web.study import Study, checked_parameters

GIVEN = 2.5


def command_line(name: str, _folder: Path) -> bool:
    """Its option is listed with its help."""
    return f"--{name.replace('_', '-')} " in cli("run", "--help")[1]


def file_of_options(name: str, folder: Path) -> bool:
    """`w2w init` writes it, and a run takes it from a file."""
    taken = []
    run.execute_bodies = lambda plan, *_: taken.append(plan.config)
    for label in ("walk", "run"):
        for number in range(2):
            path = folder / "clips" / label / f"{number}.npz"
            path.parent.mkdir(parents=True, exist_ok=True)
            motion().save(path)
    (folder / "study.toml").write_text(f"{name} = {GIVEN}")
    words = ("run", folder / "clips", "--out", folder / "out", "--config", folder / "study.toml")
    code, _ = cli(*words)
    return code == 0 and getattr(taken[0], name) == GIVEN and f"\n{name} = 1.0" in template(run.run)


def panel(name: str, _folder: Path) -> bool:
    """It is a property, which its part of the panel draws and the study heeds."""
    w2w.register()
    bpy.ops.w2w.add_body()
    study = bpy.context.scene.w2w.body.w2w
    setattr(study, name, GIVEN)
    drawn = [call.args[1] for call in draw(W2W_PT_sensor, view_of_panels()).mock_calls if "prop" in call[0]]
    return name in drawn and getattr(config_of(study), name) == GIVEN


def web(name: str, folder: Path) -> bool:
    """It is described, checked, kept, and handed on to the run's command."""
    described = json.loads(asyncio.run(Pages(None, None).interface(None)).body)["components"]["schemas"]
    asked = checked_parameters({name: GIVEN})
    study = Study.make(folder)
    study.change(parameters=asked)
    option = f"--{name.replace('_', '-')}={GIVEN}"
    return described["Parameters"]["properties"][name]["type"] == "number" and option in study.command(1, "")


def python(name: str, _folder: Path) -> bool:
    """`w2w.synthesize` takes it."""
    patches = w2w.sample_patches(w2w.Body.bundled(), 4)
    return getattr(w2w.synthesize(motion(), patches, **{name: GIVEN}).config, name) == GIVEN


def signals_key(name: str, _folder: Path) -> bool:
    """Signals by another value are other signals."""
    default = StudyConfig()
    return replace(default, **{name: GIVEN}).signal_parameters() != default.signal_parameters()


DOORS: tuple[Callable[[str, Path], bool], ...] = (
    command_line, file_of_options, panel, web, python, signals_key,
)  # fmt: skip


def motion() -> w2w.Motion:
    """A body that stands."""
    return w2w.Motion(np.tile(np.eye(3), (60, N_JOINTS, 1, 1)), np.tile((0.0, 0.0, 1.0), (60, 1)), 30.0)


def main() -> None:
    """Print the doors that know the parameter."""
    known = []
    for door in DOORS:
        with TemporaryDirectory() as folder, suppress(Exception):
            known += [door.__name__] * door(sys.argv[1], Path(folder))
    print(json.dumps({"from": w2w.__file__, "known": known}))
    sys.stdout.flush()


if __name__ == "__main__":
    main()
