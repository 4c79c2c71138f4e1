#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Install Chromium and its driver, which the report's tests need; does nothing where they are.
set -euo pipefail

packages="chromium chromium-driver"
if command -v chromium >/dev/null 2>&1 && command -v chromedriver >/dev/null 2>&1; then
  exit 0
fi
run_as_root=""
[ "$(id -u)" = 0 ] || run_as_root="sudo -n"
if command -v apt-get >/dev/null 2>&1 && $run_as_root true 2>/dev/null; then
  echo "Installing $packages"
  $run_as_root apt-get update -qq
  DEBIAN_FRONTEND=noninteractive $run_as_root apt-get install -y -qq --no-install-recommends $packages >/dev/null
else
  echo "The report's tests need Chromium and its driver. Run this line, then try again:" >&2
  echo "sudo apt-get install -y $packages" >&2
  exit 1
fi
