# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder of zips, served over loopback, is a repository: a real Blender installs from it and updates.

Needs what `test_program.py` needs; skips where one is missing.
"""

from __future__ import annotations

import functools
import http.server
import io
import shutil
import subprocess
import threading
import tomllib
import zipfile
from collections.abc import Iterator

import pytest

from .sandbox import PROJECT, RESULTS, inside, newest_zip, run_in_window

PLACE = RESULTS / "repository"
TIMEOUT_S = 600

pytestmark = pytest.mark.slow


@pytest.fixture
def site() -> Iterator[str]:
    """The address of an empty folder, `PLACE / "site"`, served over loopback."""
    newest_zip()
    shutil.rmtree(PLACE, ignore_errors=True)
    (PLACE / "site").mkdir(parents=True)
    (PLACE / "resources").mkdir()
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=PLACE / "site")
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/index.json"
        server.shutdown()


def blender(*arguments: str) -> str:
    """What a Blender with these resources says; it may go online."""
    run = [
        PROJECT / "tools" / "real_blender.sh",
        "run",
        f"BLENDER_USER_RESOURCES={inside(PLACE / 'resources')}",
    ]
    done = subprocess.run(
        [*run, "blender", "--background", "--online-mode", *arguments],
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr, done.stdout + done.stderr
    return done.stdout


def said_by(expression: str) -> str:
    """What Blender prints as it runs some Python."""
    return blender("--python-exit-code", "1", "--python-expr", expression)


def publish(version: str, folder: str = "site") -> None:
    """Put the zip under a version into the site, in place of what is there, or into another folder."""
    shutil.rmtree(PLACE / folder, ignore_errors=True)
    (PLACE / folder).mkdir()
    with (
        zipfile.ZipFile(newest_zip()) as archive,
        zipfile.ZipFile(PLACE / folder / f"w2w-{version}.zip", "w") as other,
    ):
        for name in archive.namelist():
            content = archive.read(name)
            if name == "blender_manifest.toml":
                was = f'\nversion = "{tomllib.loads(content.decode())["version"]}"\n'
                content = content.decode().replace(was, f'\nversion = "{version}"\n').encode()
            other.writestr(name, content)
    blender("--command", "extension", "server-generate", "--repo-dir", inside(PLACE / folder))


def test_install_and_update_by_clicks_keep_the_settings(site: str) -> None:
    publish("0.1.1", "next")
    publish("0.1.0")
    variables = {
        "W2W_SITE": site,
        "W2W_NEXT": inside(PLACE / "next"),
        "W2W_PUBLISHED": inside(PLACE / "site"),
        "BLENDER_USER_RESOURCES": inside(PLACE / "resources"),
    }
    report = run_in_window("from_site.py", RESULTS / "from_site", variables)
    assert (report["installed"], report["updated"]) == ("0.1.0", "0.1.1")
    assert report["threads"] == 3
    assert report["has_panel"]


OTHER = """
schema_version = "1.0.0"
id = "other"
version = "1.0.0"
name = "Other"
tagline = "Brings another version of a library"
maintainer = "Somebody"
type = "add-on"
blender_version_min = "4.3.0"
license = ["SPDX:GPL-3.0-or-later"]
wheels = ["./wheels/{wheel}"]
"""

OTHER_CODE = """
def register():
    import filelock
    print("other has", filelock.FileLock.__name__)

def unregister():
    pass
"""


def write_other(version: str) -> str:
    """An extension that brings W2W's filelock under another version; returns its path for Blender."""
    packed = io.BytesIO()
    with zipfile.ZipFile(newest_zip()) as archive:
        (own,) = [name for name in archive.namelist() if name.startswith("wheels/filelock-")]
        content = io.BytesIO(archive.read(own))
    was = own.split("-")[1]
    with zipfile.ZipFile(content) as wheel, zipfile.ZipFile(packed, "w") as changed:
        for name in wheel.namelist():
            data = wheel.read(name)
            if name.endswith("/METADATA"):
                data = data.replace(f"\nVersion: {was}".encode(), f"\nVersion: {version}".encode())
            changed.writestr(name.replace(f"-{was}.dist-info", f"-{version}.dist-info"), data)
    name = f"filelock-{version}-py3-none-any.whl"
    with zipfile.ZipFile(PLACE / "other.zip", "w") as archive:
        archive.writestr("blender_manifest.toml", OTHER.replace("{wheel}", name))
        archive.writestr("__init__.py", OTHER_CODE)
        archive.writestr(f"wheels/{name}", packed.getvalue())
    return inside(PLACE / "other.zip")


@pytest.mark.parametrize("version", ["2.0.0", "99.0.0"])
def test_another_extension_with_another_version_of_a_library_lives_beside(site: str, version: str) -> None:
    publish("0.1.0")
    blender("--command", "extension", "repo-add", "--name", "W2W", "--url", site, "w2w_site")
    other = write_other(version)
    blender("--command", "extension", "install-file", "--repo", "user_default", "--enable", other)
    blender("--command", "extension", "install", "--sync", "--enable", "w2w_site.w2w")
    found = said_by(
        "import w2w, importlib.metadata as m; print(w2w.__file__, 'filelock', m.version('filelock'))"
    )
    assert "site-packages/w2w/__init__.py" in found
    assert "other has " in found
    assert f"filelock {'99.' if version == '99.0.0' else '4.'}" in found  # the newest is for all
    assert "Usage" in blender("--command", "w2w", "report", "--help")
