#!/bin/sh
# SPDX-License-Identifier: MIT
# The README's two commands on a Debian 12 with git and nothing else: bare_debian.sh FOLDER [MIRROR]
# Makes a system in FOLDER (debootstrap, root), clones this repository's HEAD into it, runs both commands there, the
# demo twice, and says minutes and megabytes. Half an hour; not part of run.sh, which it runs.
set -eu
[ $# -ge 1 ] || { sed -n '3,5s/^# //p' "$0" >&2; exit 1; }
[ "$(id -u)" = 0 ] && command -v debootstrap >/dev/null || { echo "needs root and debootstrap" >&2; exit 77; }
source=$(cd "$(dirname "$0")/../.." && pwd)
system=$1

megabytes() { du -xsm --exclude="$system/proc" "$system" | cut -f1; }
timed() {
    began=$(date +%s)
    chroot "$system" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/opt "$@" </dev/null
    echo "bare_debian: $*: $((($(date +%s) - began + 30) / 60)) minutes, $(megabytes) MB in all"
}

# The mirror that this machine itself installs from, unless another is given.
mirror=${2:-$(apt-get indextargets --format '$(SITE)' | head -n 1)}
[ -x "$system/usr/bin/apt-get" ] || debootstrap --variant=minbase bookworm "$system" "$mirror"
cp /etc/resolv.conf "$system/etc/resolv.conf"
mount -t proc proc "$system/proc" 2>/dev/null || mount --bind /proc "$system/proc"
trap 'umount "$system/proc"' EXIT
chroot "$system" sh -c 'apt-get update -qq && apt-get install -y -qq --no-install-recommends git >/dev/null'
git clone -q "$source" "$system/opt/voxshell"
echo "bare_debian: $(megabytes) MB before"
timed /opt/voxshell/samples/demo.sh
timed /opt/voxshell/samples/demo.sh
timed /opt/voxshell/tests/run.sh
