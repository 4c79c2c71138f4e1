#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Install Chromium and its driver, which the report's tests need; does nothing where they are.
set -euo pipefail

if command -v chromium >/dev/null 2>&1 && command -v chromedriver >/dev/null 2>&1; then
  exit 0
fi
"$(dirname "$0")/install_packages.sh" "Installing" "The report's tests need Chromium and its driver." chromium chromium-driver
