# SPDX-License-Identifier: GPL-3.0-or-later
"""Build all that a release has into dist/release: `make release`.

Extension zips for every platform and Python with the index that makes the folder a repository of Blender's,
wheels and sdists for pip, conda-forge's recipe, the site, notes and checksums. The same tree gives the same
bytes.
"""

from __future__ import annotations

import gzip
import hashlib
import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

from blender_wheels import PLATFORMS, PROJECT
from build_extension import EPOCH, SERIES, blender_tool, build

RELEASE = PROJECT / "dist" / "release"
PACK = (
    "import sys; from setuptools.build_meta import build_sdist, build_wheel; folder = sys.argv[1]; "
    "build_wheel(folder); build_sdist(folder)"
)


def main(platforms: list[str]) -> None:
    """Empty the folder and fill it again."""
    shutil.rmtree(RELEASE, ignore_errors=True)
    RELEASE.mkdir(parents=True)
    for platform in platforms:
        for python, blenders in SERIES.items():
            build(platform, python, blenders, RELEASE)
    blender_tool("server-generate", "--repo-dir", str(RELEASE))
    make_packages()
    make_site()
    shutil.copyfile(PROJECT / "CHANGELOG.md", RELEASE / "NOTES.md")
    (sdist,) = RELEASE.glob("where_to_wear-*.tar.gz")
    recipe = (PROJECT / "release/conda/recipe.yaml").read_text(encoding="utf-8")
    filled = recipe.replace("HASH_OF_THE_SDIST", hashlib.sha256(sdist.read_bytes()).hexdigest())
    (RELEASE / "recipe.yaml").write_text(filled, encoding="utf-8")
    files = sorted(RELEASE.iterdir())
    lines = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in files]
    (RELEASE / "SHA256SUMS").write_text("".join(lines), encoding="utf-8")
    print("".join(lines), *[f"open: {what}" for what in still_open()], sep="\n")


def still_open() -> list[str]:
    """What waits for a public address, which `[project.urls]` of pyproject.toml is the one place for."""
    urls = tomllib.loads((PROJECT / "pyproject.toml").read_text("utf-8"))["project"].get("urls", {})
    if not (address := urls.get("Repository")):
        return [
            "[project.urls] of pyproject.toml has no Repository: no address for issues, clone and citation"
        ]
    named = {
        "CITATION.cff": f'repository-code: "{address}"',
        "README.md": f"git clone {address}",
        "release/conda/recipe.yaml": f"homepage: {address}",
    }
    return [
        f"{file} lacks {line}"
        for file, line in named.items()
        if line not in (PROJECT / file).read_text("utf-8")
    ]


def make_packages() -> None:
    """Wheels and sdists, of W2W and of its studies, from the files that git knows."""
    tree = RELEASE / "tree"
    tracked = subprocess.run(["git", "ls-files", "-z"], cwd=PROJECT, capture_output=True, check=True).stdout
    for name in tracked.decode().strip("\0").split("\0"):
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(PROJECT / name, tree / name)
    environment = os.environ | {"SOURCE_DATE_EPOCH": str(EPOCH)}
    command = [sys.executable, "-c", PACK, RELEASE]
    for package in (tree, tree / "packages" / "studies"):
        subprocess.run(command, cwd=package, env=environment, check=True, capture_output=True)
    shutil.rmtree(tree)
    for sdist in RELEASE.glob("*.tar.gz"):
        _make_same_bytes(sdist)


def _make_same_bytes(sdist: Path) -> None:
    """Write an sdist again, with its files in order, of one time and no owner."""
    with tarfile.open(sdist) as packed:
        members = {one: packed.extractfile(one) for one in sorted(packed, key=lambda one: one.name)}
        zipped = gzip.GzipFile(sdist.with_suffix(".part"), "wb", mtime=EPOCH)
        with zipped, tarfile.open(fileobj=zipped, mode="w") as again:
            for one, content in members.items():
                one.mtime, one.uid, one.gid, one.uname, one.gname = EPOCH, 0, 0, "", ""
                one.pax_headers = {}
                again.addfile(one, content)
    sdist.with_suffix(".part").replace(sdist)


def make_site() -> None:
    """The documents as `make docs` builds them, in one zip."""
    site = RELEASE / "site"
    environment = os.environ | {"SOURCE_DATE_EPOCH": str(EPOCH), "NO_MKDOCS_2_WARNING": "1"}
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", site]
    subprocess.run(command, cwd=PROJECT, env=environment, check=True)
    with zipfile.ZipFile(RELEASE / "site.zip", "w", zipfile.ZIP_DEFLATED) as packed:
        for path in sorted(path for path in site.rglob("*") if path.is_file()):
            packed.writestr(zipfile.ZipInfo(path.relative_to(site).as_posix()), path.read_bytes())
    shutil.rmtree(site)


if __name__ == "__main__":
    main(sys.argv[1:] or list(PLATFORMS))
