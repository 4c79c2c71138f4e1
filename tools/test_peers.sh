#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Read W2W's files with the programs they are for: gaitmap (and its pandas), OpenSim and the BIDS validator.
# The first two want another NumPy than Blender's and than each other's, so each gets a virtual environment of
# its own under .venv-peers. x-io's small readers are among the ordinary test libraries.
set -euo pipefail
cd "$(dirname "$0")/.."
python=${PYTHON:-python3.11}
tests=tests/core/imu/test_recording.py

# environment NAME REQUIREMENT...
environment() {
  local venv=".venv-peers/$1"
  shift
  local stamp
  stamp="$venv/.ready-$(echo "$@" | cksum | cut -d" " -f1)"
  if [ ! -e "$stamp" ]; then
    rm -rf "$venv"
    "$python" -m venv "$venv"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
    touch "$stamp"
  fi
}

# run_tests PYTHON NAME ARGUMENT...
run_tests() {
  local report=".venv-peers/$2/report.xml" interpreter=$1
  shift 2
  "$interpreter" -m pytest -q "$@" --junitxml "$report"
  # a test that was skipped has read nothing
  grep -q 'skipped="0"' "$report"
}

# test_with NAME TESTS REQUIREMENT...
test_with() {
  local name=$1 chosen=$2
  shift 2
  environment "$name" "$@" filelock h5py==3.16.0 hypothesis==6.170.15 pytest==9.2.0 scipy
  run_tests ".venv-peers/$name/bin/python" "$name" "$tests" -k "$chosen"
}

# tpcp, which gaitmap brings, is a pytest plugin that does not load without numpydoc
test_with gaitmap "gaitmap_takes or pandas" gaitmap==2.6.0 numpydoc==1.8.0
test_with opensim opensim_reads opensim==4.6

# loaders of pose estimators, stated anew in the tests: with PyTorch, among the ordinary test libraries
run_tests "$python" poses tests/headless/commands/test_export_poses.py

environment bids bids-validator-deno==3.0.2
W2W_BIDS_VALIDATOR="$PWD/.venv-peers/bids/bin/bids-validator-deno" \
  run_tests "$python" bids tests/headless/commands/test_export_bids.py
