#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Install Debian packages where root may be had, else print the line to run and fail.
# Usage: tools/install_packages.sh ANNOUNCEMENT WHAT_NEEDS_THEM PACKAGE...
set -euo pipefail
announcement=$1 need=$2
shift 2

run_as_root=""
[ "$(id -u)" = 0 ] || run_as_root="sudo -n"
if command -v apt-get >/dev/null 2>&1 && $run_as_root true 2>/dev/null; then
  echo "$announcement $*"
  exec 9<"$(dirname "$0")"
  flock 9 # the tests' lanes may need packages at the same time
  $run_as_root apt-get update -qq
  DEBIAN_FRONTEND=noninteractive $run_as_root apt-get -o DPkg::Lock::Timeout=600 install -y -qq \
    --no-install-recommends "$@" >/dev/null
else
  echo "$need Run this line, then try again:" >&2
  echo "sudo apt-get install -y $*" >&2
  exit 1
fi
