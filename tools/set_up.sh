#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Make the virtual environment that everything else runs in; does nothing when it is up to date.
# Usage: tools/set_up.sh [FOLDER] [BPY_VERSION]
set -euo pipefail
cd "$(dirname "$0")/.."
venv=${1:-.venv}
bpy=${2:-4.5.15}

libraries="libx11-6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libsm6 libice6 libgl1"

python=""
for candidate in "${PYTHON:-}" python3.11 python3 python; do
  if [ -n "$candidate" ] && command -v "$candidate" >/dev/null 2>&1 &&
    "$candidate" -c 'import sys; raise SystemExit(sys.version_info[:2] != (3, 11))' 2>/dev/null; then
    python=$candidate
    break
  fi
done
if [ -z "$python" ]; then
  echo "W2W needs Python 3.11, as Blender's module does, and none was found." >&2
  echo "Install it (on Debian 12: apt-get install python3.11-venv) or name it: PYTHON=/path/to/python3.11 make" >&2
  exit 1
fi

stamp="$venv/.ready-$({ cat pyproject.toml constraints.txt "$0"; echo "$bpy"; } | sha256sum | cut -c1-16)"
if [ -e "$stamp" ]; then
  exit 0
fi

# Blender's module is linked against a few X11 libraries, even without a window.
if command -v dpkg >/dev/null 2>&1; then
  missing=""
  for library in $libraries; do
    dpkg -s "$library" >/dev/null 2>&1 || missing="$missing $library"
  done
  if [ -n "$missing" ]; then
    # shellcheck disable=SC2086
    tools/install_packages.sh "Installing system libraries:" "Blender's Python module needs system libraries." $missing
  fi
fi

echo "Setting up $venv with bpy $bpy (once; Blender's module is about 370 MB)"
[ -x "$venv/bin/python" ] || "$python" -m venv "$venv"
export PIP_CONSTRAINT="$PWD/constraints.txt" PIP_DISABLE_PIP_VERSION_CHECK=1
"$venv/bin/python" -m pip install --quiet "bpy==$bpy" --editable ".[test]"
rm -f "$venv"/.ready-*
touch "$stamp"
