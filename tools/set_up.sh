#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Make the virtual environment that everything else runs in; does nothing when it is up to date.
# Usage: tools/set_up.sh [FOLDER BPY_VERSION]: with a folder, an environment with another bpy over .venv's libraries.
set -euo pipefail
cd "$(dirname "$0")/.."
venv=${1:-.venv}
bpy=${2:-4.5.15}

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

# What pip does not bring: Debian leaves venv out of its Python, and Blender's module opens libraries of
# the system, even without a window.
needs="" packages=""
for missing in $("$python" -I blender_addon/w2w/headless/system_libraries.py); do
  needs="$needs ${missing%=*}" packages="$packages ${missing#*=}"
done
if [ ! -x "$venv/bin/python" ] && ! "$python" -I -c 'import ensurepip' 2>/dev/null; then
  needs="$needs venv" packages="$packages python3.11-venv"
fi
if [ -n "$packages" ]; then
  # shellcheck disable=SC2086
  tools/install_packages.sh "Installing system packages:" "W2W needs what this machine lacks:$needs." $packages
fi

stamp="$venv/.ready-$({ cat pyproject.toml packages/studies/pyproject.toml setup.py constraints.txt "$0"; echo "$bpy"; } | cksum | cut -d" " -f1)"
if [ -e "$stamp" ]; then
  exit 0
fi

echo "Setting up $venv with bpy $bpy (once; Blender's module is about 370 MB)"
[ -x "$venv/bin/python" ] || "$python" -m venv "$venv"
export PIP_CONSTRAINT="$PWD/constraints.txt" PIP_DISABLE_PIP_VERSION_CHECK=1
# Python compiles what it imports; compiling all of it would take as long as the rest.
if [ "$venv" = .venv ]; then
  "$venv/bin/python" -m pip install --quiet --no-compile "bpy==$bpy" --editable ".[test,docs]" --editable packages/studies
  # Editors and mypy follow plain paths, not the import hook of an editable install.
  printf '%s\n' "$PWD/blender_addon" "$PWD/packages/studies" >"$venv/lib/python3.11/site-packages/where_to_wear_paths.pth"
else
  tools/set_up.sh
  "$venv/bin/python" -m pip install --quiet --no-compile --no-deps "bpy==$bpy"
  echo "import site; site.addsitedir('$PWD/.venv/lib/python3.11/site-packages')" \
    >"$venv/lib/python3.11/site-packages/libraries_of_venv.pth"
fi
rm -f "$venv"/.ready-*
touch "$stamp"
