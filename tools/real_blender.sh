#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# A real Blender with a (virtual) screen, for the GUI tests: Debian trixie's Blender 4.3.2 in a folder of its
# own, with Xvfb, ImageMagick and Mesa's software OpenGL. Nothing outside that folder is changed but
# the key of Debian's archive, which is installed where it is missing. Needs root and a Debian or Ubuntu machine.
#
#   tools/real_blender.sh              set up, or do nothing where it is set up already; print the folder
#   tools/real_blender.sh run CMD...   run a command inside, /project being the project's folder
#
# The folder is .sandbox/blender-4.3 unless W2W_BLENDER_SANDBOX names another; W2W_BLENDER_SHARE names a folder
# that tests read (the real motion files), seen inside as /shared. W2W_DEBIAN=sid takes the newest Blender that
# Debian has (5.2 today) instead; name another folder for it, as `make test-window-5.2` does.
set -euo pipefail
project=$(cd "$(dirname "$0")/.." && pwd)
root=${W2W_BLENDER_SANDBOX:-$project/.sandbox/blender-4.3}
# the mirror that this machine's apt uses, unless W2W_DEBIAN_MIRROR names another
mirror=${W2W_DEBIAN_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep -v security | head -n 1)}
suite=${W2W_DEBIAN:-trixie}
keyring=/usr/share/keyrings/debian-archive-keyring.gpg
packages="blender xvfb xauth imagemagick libgl1-mesa-dri libegl1 fonts-dejavu-core python3-numpy python3-requests"
packages="$packages python3-xlib"
[ "$suite" = trixie ] || packages="$packages python3-cattr" # Blender 5.2's own add-on for extensions imports it

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }

# Unpacking on all cores and running no package's scripts takes a third of the time of debootstrap and apt.
set_up() {
    [ -e "$root/.ready" ] && return
    if [ ! -e "$keyring" ]; then
        "$project/tools/install_packages.sh" Installing "Debian's packages are checked by its key." \
            debian-archive-keyring >&2
    fi
    as_root rm -rf --one-file-system "$root"
    as_root mkdir -p "$root"/{etc/apt/{apt.conf.d,preferences.d,trusted.gpg.d},var/{lib/{apt/lists,dpkg},cache/apt/archives}} \
        "$root"/{dev,proc,sys,tmp,root,project,shared}
    as_root touch "$root/var/lib/dpkg/status"
    echo "deb [signed-by=$keyring] $mirror $suite main" | as_root tee "$root/etc/apt/sources.list" >/dev/null
    # shellcheck disable=SC2086
    apt_inside update -qq && apt_inside install -y -qq --no-install-recommends --download-only '?essential' $packages
    (
        cd "$root/var/cache/apt/archives"
        as_root dpkg-deb --extract base-files_*.deb "$root" # the links /bin and /lib, before what goes through them
        find . -name '*.deb' -printf '%s %p\n' | sort -rn | cut -d' ' -f2 |
            as_root xargs -P "$(nproc)" -n 1 sh -c 'dpkg-deb --extract "$1" "$0"' "$root"
    )
    as_root rm -r "$root"/var/cache/apt/archives
    finish
    as_root touch "$root/.ready"
}

# apt of this machine, at work in the folder.
apt_inside() {
    as_root env DEBIAN_FRONTEND=noninteractive apt-get -o Dir="$root" -o Dir::State::status="$root/var/lib/dpkg/status" \
        -o APT::Sandbox::User=root -o Acquire::Languages=none -o APT::Get::AllowUnauthenticated=false "$@"
}

# The little of the packages' scripts that the tests need.
finish() {
    local file
    as_root cp "$root/usr/share/base-passwd/passwd.master" "$root/etc/passwd"
    as_root cp "$root/usr/share/base-passwd/group.master" "$root/etc/group"
    for file in "$root"/usr/lib/*/{blas,lapack}/*.so.3; do
        as_root ln -sf "$(basename "$(dirname "$file")")/$(basename "$file")" "$(dirname "$(dirname "$file")")/"
    done
    as_root ln -sf "$(basename "$root"/usr/bin/import-im*)" "$root/usr/bin/import"
    as_root ln -sf mawk "$root/usr/bin/awk"
    as_root chroot "$root" ldconfig
}

# Mounts live in a namespace of their own and vanish with the command.
run() {
    as_root mkdir -p "$root/project" "$root/shared"
    as_root unshare --mount bash -c '
        set -e
        root=$1 project=$2 share=$3
        shift 3
        mount --make-rprivate /
        mount -t proc proc "$root/proc"
        mount --rbind /dev "$root/dev"
        mount --bind "$project" "$root/project"
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
