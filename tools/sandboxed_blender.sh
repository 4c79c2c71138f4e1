#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The Blender that tools/real_blender.sh sets up, as a program by itself: for make's BLENDER=.
exec "$(dirname "$0")/real_blender.sh" run blender "$@"
