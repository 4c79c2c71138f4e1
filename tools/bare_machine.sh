#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# README's two commands on a bare machine: a minimal Debian 12 with make and Python, and nothing else, in a
# folder. First a user without rights must be told what is missing, then root runs both commands; with the word
# `all`, as by night, the user runs them, too, and at last come the lines of the Dockerfile.
# Needs root (or sudo) on Debian or Ubuntu. Where it cannot run it says so, and fails if CI is set.
#
# The Debian and the packages downloaded are kept in W2W_BARE_CACHE (~/.cache/where-to-wear/bare unless told), the
# mirror is this machine's unless W2W_DEBIAN_MIRROR names another. Nothing outside that folder is changed but
# debootstrap, which is installed where it is missing.
set -euo pipefail
project=$(cd "$(dirname "$0")/.." && pwd)
export W2W_BARE_CACHE=${W2W_BARE_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/where-to-wear/bare}
cache=$W2W_BARE_CACHE machine=$W2W_BARE_CACHE/machine home=/srv/where-to-wear
quick="tests/core/imu/test_synthesis.py tests/scene/test_heatmap.py tests/headless/reports/test_draw.py"

cannot() {
    echo "The bare machine cannot be tried here: $1." >&2
    [ -z "${CI:-}" ] || exit 1
    exit 0
}

failed() {
    echo "Bare machine: $1" >&2
    exit 1
}

if [ "$(id -u)" != 0 ]; then
    sudo -n true 2>/dev/null || cannot "it needs root"
    exec sudo -n --preserve-env "$0" "$@"
fi

# Debian as debootstrap leaves it, made once.
set_up() {
    local mirror packages=make,python3-venv,ca-certificates
    mirror=${W2W_DEBIAN_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep -v security | head -n 1)}
    pristine=$cache/debian-$(echo "$packages $mirror" | sha256sum | cut -c1-8)
    [ ! -d "$pristine" ] || return 0
    if ! command -v debootstrap >/dev/null || [ ! -e /usr/share/keyrings/debian-archive-keyring.gpg ]; then
        "$project/tools/install_packages.sh" Installing "A bare machine needs debootstrap." \
            debootstrap debian-archive-keyring || cannot "debootstrap is not to be had"
    fi
    echo "Making a bare Debian 12 in $pristine"
    rm -rf --one-file-system "$pristine.part"
    debootstrap --variant=minbase --include="$packages" bookworm "$pristine.part" "$mirror" >"$cache/debootstrap.log" ||
        cannot "debootstrap failed; see $cache/debootstrap.log"
    mv "$pristine.part" "$pristine"
}

# A fresh copy of it, with the project, a user, and the way to the package indexes that this machine has.
make_machine() {
    rm -rf --one-file-system "$machine"
    cp -a "$pristine" "$machine"
    chroot "$machine" useradd --create-home --shell /bin/bash wearer
    mkdir -p "$machine$home" "$machine/root/.cache/pip" "$cache/apt/partial" "$cache/pip"
    (cd "$project" && git -c safe.directory='*' ls-files -z --cached --others --exclude-standard |
        while IFS= read -r -d '' file; do [ ! -e "$file" ] || printf '%s\0' "$file"; done |
        tar --create --null --files-from - | tar --extract --no-same-owner --directory "$machine$home")
    chroot "$machine" chown -R wearer: "$home"
    pip_settings >"$machine/etc/pip.conf"
    apt-config dump | grep -E '^Acquire::(https?|Retries)' >"$machine/etc/apt/apt.conf.d/99machine" || true
    for file in /etc/resolv.conf /etc/hosts /etc/ssl/certs/ca-certificates.crt; do
        [ ! -e "$file" ] || cp --remove-destination -L "$file" "$machine$file"
    done
}

# pip's settings here that say where packages come from, the environment's above the files'.
pip_settings() {
    echo "[global]"
    python3 -m pip config list 2>/dev/null | sed -E "s/^[^.]*\.([a-z-]+)='(.*)'$/\1 = \2/; s/\\\\n/ /g" |
        grep -E '^((extra-)?index-url|find-links|cert|trusted-host|proxy|(default-)?timeout|retries|no-index) = ' |
        tac | awk '!seen[$1]++'
}

# Folders and files of this machine that these settings name; an index's links lead to folders beside it.
named_paths() {
    tr ' ' '\n' <"$machine/etc/pip.conf" | grep -E '^(file://)?/' | sort -u |
        while read -r path; do
            case $path in file://*) path=$(dirname "${path#file://}") ;; esac
            [ ! -e "$path" ] || echo "$path"
        done | sort -u
}

# inside USER COMMAND: mounts and processes live in namespaces of their own and vanish with the command.
inside() {
    local proxies
    proxies=$(env | grep -iE '^(https?|no)_proxy=' || true)
    # shellcheck disable=SC2016
    named_paths | unshare --mount --pid --fork --kill-child bash -c '
        set -euo pipefail
        machine=$1 cache=$2 home=$3 proxies=$4 user=$5 command=$6
        mount --make-rprivate /
        mount -t proc proc "$machine/proc"
        mount --rbind /dev "$machine/dev"
        mount --bind "$cache/pip" "$machine/root/.cache/pip"
        mount --bind "$cache/apt" "$machine/var/cache/apt/archives"
        while read -r path; do
            if [ -d "$path" ]; then mkdir -p "$machine$path"; else mkdir -p "$machine$(dirname "$path")"; fi
            [ -e "$machine$path" ] || touch "$machine$path"
            mount --bind -o ro "$path" "$machine$path"
        done
        mapfile -t proxies <<<"$proxies"
        exec chroot --userspec="$user:$user" "$machine" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
            HOME="$(chroot "$machine" getent passwd "$user" | cut -d: -f6)" "${proxies[@]}" \
            bash -c "cd $home && $command" </dev/null' bash "$machine" "$cache" "$home" "${proxies:-no_proxy=}" "$1" "$2"
}

step() {
    echo
    echo "== $1 ($((SECONDS / 60)) min $((SECONDS % 60)) s)"
}

told_what_is_missing() {
    local said package
    if said=$(inside wearer "make demo" 2>&1); then
        failed "'make demo' works without the system's libraries, so this test is worth nothing"
    fi
    echo "$said"
    for package in $(inside wearer "python3 -I blender_addon/w2w/headless/system_libraries.py" | tr ' ' '\n' | cut -d= -f2); do
        grep -q "sudo apt-get install .*\b$package\b" <<<"$said" || failed "the line to run does not name $package"
    done
    [ ! -e "$machine$home/.venv" ] || failed "the long step was begun before the libraries were looked for"
}

wrote() {
    local name
    for name in report.html summary.json utility.csv study.blend heatmaps/mean.png; do
        [ -s "$machine$1/results/$name" ] || failed "$1/results/$name is missing"
    done
}

mkdir -p "$cache"
exec 9>"$cache/lock"
flock 9
command -v apt-get >/dev/null || cannot "it needs Debian or Ubuntu"
unshare --mount --pid --fork true 2>/dev/null || cannot "mount namespaces are not allowed"
set_up
trap 'rm -rf --one-file-system "$machine"' EXIT
make_machine
step "a user without rights, on a machine without the system's libraries: make demo"
told_what_is_missing
step "root: make demo"
chroot "$machine" chown -R root: "$home"
inside root "make demo"
wrote "$home/demo_output"
step "root: make test"
inside root "make -o lint test TESTS='$quick'" # which is the same on any machine
if [ "${1:-}" != all ]; then
    step "all well"
    exit
fi
step "a user without rights: make test, w2w demo"
chroot "$machine" chown -R wearer: "$home"
inside wearer "make test TESTS='tests/core/imu/test_synthesis.py' && .venv/bin/w2w demo --clips 2 --out ~/small"
wrote /home/wearer/small
step "root: the Dockerfile's lines"
chroot "$machine" chown -R root: "$home"
cp -a "$machine$home" "$machine/w2w"
rm -rf "$machine/w2w/.venv"
sed -n 's/^RUN //p' "$project/Dockerfile" | while read -r line; do inside root "$line"; done
inside wearer "/opt/w2w/bin/w2w demo --clips 2 --out ~/container"
wrote /home/wearer/container
inside wearer "/opt/w2w/bin/python -c 'import uvicorn, w2w.web.app'"
step "all well"
