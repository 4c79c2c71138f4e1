#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Get W2W's libraries for the Python of a Blender program, into .venv-blender-pythonX.Y; does nothing when they
# are there. Usage: tools/set_up_blender.sh BLENDER
set -euo pipefail
cd "$(dirname "$0")/.."
for python in .venv/bin/python "${PYTHON:-}" python3 python; do
  if [ -n "$python" ] && "$python" -c 'import pip, sys; sys.exit(sys.version_info < (3, 9))' 2>/dev/null; then
    exec "$python" tools/set_up_blender.py "$1"
  fi
done
echo "No Python with pip was found, which gets the libraries (on Debian: apt-get install python3-pip)." >&2
exit 1
