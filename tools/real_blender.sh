#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# A real Blender with a (virtual) screen, for the GUI tests: Debian trixie's Blender 4.3.2 in a folder of its
# own, with Xvfb, xdotool, ImageMagick and Mesa's software OpenGL. Nothing outside that folder is changed but
# debootstrap, which is installed where it is missing. Needs root (chroot) and a Debian or Ubuntu machine.
#
#   tools/real_blender.sh              set up, or do nothing where it is set up already; print the folder
#   tools/real_blender.sh run CMD...   run a command inside, /work being the project's folder
#
# The folder is .sandbox/blender-4.3 unless W2W_BLENDER_SANDBOX names another; W2W_BLENDER_SHARE names a folder
# that tests read (the real motion files), seen inside as /shared.
set -euo pipefail
project=$(cd "$(dirname "$0")/.." && pwd)
root=${W2W_BLENDER_SANDBOX:-$project/.sandbox/blender-4.3}
# the mirror that this machine's apt uses, unless W2W_DEBIAN_MIRROR names another
mirror=${W2W_DEBIAN_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep -v security | head -n 1)}
packages="blender xvfb xauth xdotool imagemagick x11-utils libgl1-mesa-dri libegl1 fonts-dejavu-core
    python3-numpy python3-requests"

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }

set_up() {
    [ -e "$root/.ready" ] && return
    if ! command -v debootstrap >/dev/null; then
        as_root apt-get update -qq && as_root apt-get install -y -qq --no-install-recommends debootstrap
    fi
    if [ ! -e "$root/.base" ]; then
        as_root rm -rf --one-file-system "$root"
        mkdir -p "$root"
        as_root debootstrap --variant=minbase trixie "$root" "$mirror"
        printf 'force-unsafe-io\n' | as_root tee "$root/etc/dpkg/dpkg.cfg.d/fast" >/dev/null
        printf '#!/bin/sh\nexit 101\n' | as_root tee "$root/usr/sbin/policy-rc.d" >/dev/null
        as_root chmod +x "$root/usr/sbin/policy-rc.d"
        as_root touch "$root/.base"
    fi
    # shellcheck disable=SC2086
    as_root chroot "$root" env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends $packages
    as_root chroot "$root" apt-get clean
    as_root touch "$root/.ready"
}

# Mounts live in a namespace of their own and vanish with the command.
run() {
    as_root mkdir -p "$root/work" "$root/shared"
    as_root unshare --mount bash -c '
        set -e
        root=$1 project=$2 share=$3
        shift 3
        mount --make-rprivate /
        mount -t proc proc "$root/proc"
        mount --rbind /dev "$root/dev"
        mount --bind "$project" "$root/work"
        [ -z "$share" ] || mount --bind -o ro "$share" "$root/shared"
        mount -t tmpfs tmpfs "$root/tmp"
        exec chroot "$root" env -i HOME=/root PATH=/usr/local/bin:/usr/bin:/bin LANG=C.UTF-8 \
            LIBGL_ALWAYS_SOFTWARE=1 "$@"' bash "$root" "$project" "${W2W_BLENDER_SHARE:-}" "$@"
}

set_up >&2
if [ "${1:-}" = run ]; then
    shift
    run "$@"
else
    echo "$root"
fi
