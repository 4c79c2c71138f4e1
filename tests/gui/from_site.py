# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension from a static site by clicks: run inside Blender by `test_repository.py`.

Environment: W2W_SITE the address of the index, W2W_NEXT a folder with the next version's files, W2W_PUBLISHED
the folder that is served, W2W_OUT where the report and pictures go.
"""

from __future__ import annotations

import os
import shutil
import sys
import tomllib
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import Driver, Script
from panel import play, report

MODULE = "bl_ext.w2w_site.w2w"
ACROSS = (0.9, 0.85, 0.8, 0.95, 0.75, 0.7)
"""Where across the preferences an extension's button may stand."""


class Preferences(Driver):
    """Mouse and eyes on the preferences, which stand where the 3D view was."""

    @property
    def area(self) -> bpy.types.Area:
        return next(area for area in self.window.screen.areas if area.type == "PREFERENCES")

    def region(self, kind: str) -> bpy.types.Region:  # noqa: ARG002
        return super().region("WINDOW")


def installed_version() -> str:
    """The version of W2W that Blender has unpacked; empty where it has none."""
    manifest = Path(bpy.utils.user_resource("EXTENSIONS"), "w2w_site", "w2w", "blender_manifest.toml")
    return tomllib.loads(manifest.read_text())["version"] if manifest.exists() else ""


def own() -> bpy.types.AddonPreferences:
    """W2W's preferences."""
    return bpy.context.preferences.addons[MODULE].preferences


def add_repository(driver: Driver) -> Script:
    """Open the preferences where the 3D view is, and name the site."""
    preferences = bpy.context.preferences
    preferences.system.use_online_access = True
    for repository in list(preferences.extensions.repos):
        if repository.use_remote_url:
            preferences.extensions.repos.remove(repository)
    bpy.ops.preferences.extension_repo_add(
        name="w2w_site", remote_url=os.environ["W2W_SITE"], type="REMOTE", use_sync_on_startup=False
    )
    driver.area.ui_type = "PREFERENCES"
    preferences.active_section = "EXTENSIONS"
    index = Path(preferences.extensions.repos[-1].directory, ".blender_ext", "index.json")
    yield from driver.until(index.exists)
    yield from driver.turns(100)


def press(wanted: str) -> Script:
    """Find a button of the preferences and click it."""
    window = Preferences(Path(os.environ["W2W_OUT"], "pictures"))
    x, y = yield from window.find(wanted, ACROSS)
    yield from window.click(x, y)


def install(driver: Driver) -> Script:
    """Press Install beside W2W in the list, and change a setting of its own."""
    driver.photograph("offered")
    yield from press("package_install(")
    yield from driver.until(lambda: MODULE in bpy.context.preferences.addons, 300)
    yield from driver.turns(20)
    report["installed"] = installed_version()
    own().threads = 3
    driver.photograph("installed")


def update(driver: Driver) -> Script:
    """Press Update once the site has another version."""
    published = Path(os.environ["W2W_PUBLISHED"])
    for path in published.iterdir():
        path.unlink()
    shutil.copytree(os.environ["W2W_NEXT"], published, dirs_exist_ok=True)
    bpy.ops.extensions.repo_sync_all("INVOKE_DEFAULT")
    yield from driver.until(lambda: not driver.window.modal_operators)
    yield from driver.turns(20)
    driver.photograph("outdated")
    yield from press("package_install(")
    yield from driver.until(lambda: installed_version() != report["installed"], 300)
    yield from driver.until(lambda: not driver.window.modal_operators)
    yield from driver.turns(20)
    report["updated"] = installed_version()
    report["threads"] = own().threads
    report["has_panel"] = "W2W" in {
        getattr(one, "bl_category", "") for one in bpy.types.Panel.__subclasses__()
    }
    driver.photograph("updated")


play(add_repository, install, update)
