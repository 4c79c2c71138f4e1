# SPDX-License-Identifier: GPL-3.0-or-later
"""Get W2W's libraries, but for numpy, for the Python of a Blender program; see `set_up_blender.sh`.

They need not fit the Python that runs this: pip picks the wheels for Blender's.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys

from blender_wheels import PROJECT, ask_blender, versions_for


def main(blender: str) -> None:
    """Fill the folder for a Blender's Python, whole or not at all."""
    python = ask_blender(blender)
    wanted = sorted(f"{name}=={version}" for name, version in versions_for(python, os.name == "nt").items())
    folder = PROJECT / f".venv-blender-python{python}"
    stamp = folder / f".ready-{hashlib.sha256(' '.join(wanted).encode()).hexdigest()[:16]}"
    if stamp.exists():
        return
    print(f"Getting W2W's libraries for the Python {python} of {blender}")
    part = folder.with_name(folder.name + ".part")
    for old in (part, folder):
        if old.exists():
            shutil.rmtree(old)
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]
    pip += ["--no-compile", "--only-binary=:all:", f"--python-version={python}", "--implementation=cp"]
    if subprocess.run([*pip, f"--target={part}", *wanted], check=False).returncode:
        raise SystemExit(f"pip could not get the libraries for Python {python}; its messages are above")
    (part / stamp.name).touch()
    part.rename(folder)
    print(f"They are in {folder}: {blender} --background --python headless/run.py -- LIBRARY --out OUT")


if __name__ == "__main__":
    main(sys.argv[1])
