#!/bin/sh
# SPDX-License-Identifier: MIT
# The packages on a Debian 12 with nothing else: debs.sh BUILD FOLDER [MIRROR]
# Packs BUILD (cpack), makes a system in FOLDER (debootstrap, root) if there is none, installs the packages there as
# people do (apt), converts and simulates, compiles a program, and takes them away again. Says seconds and megabytes.
# Not part of run.sh. Five minutes, nearly all of it debootstrap.
set -eu
[ $# -ge 2 ] || { sed -n '3,6s/^# //p' "$0" >&2; exit 1; }
[ "$(id -u)" = 0 ] && command -v debootstrap >/dev/null || { echo "debs: needs root and debootstrap" >&2; exit 77; }
source=$(cd "$(dirname "$0")/../.." && pwd)
build=$(readlink -f "$1") system=$2
mirror=${3:-$(apt-get indextargets --format '$(SITE)' | head -n 1)}
[ -x "$system/usr/bin/apt-get" ] || debootstrap --variant=minbase bookworm "$system" "$mirror" >/dev/null
rm -rf "$system/packages"
mkdir "$system/packages"
(cd "$build" && cpack -G DEB -B "$build/packages" -D CPACK_PACKAGE_DIRECTORY="$system/packages" >/dev/null 2>&1)
cp "$build/samples/cup.stl" "$build/samples/cup_press.scene.json" "$build/samples/cup.glb" "$build/samples/sphere.glb" "$system/packages/"
cp -r "$source/tests/install/consumer" "$system/packages/"
cp /etc/resolv.conf "$system/etc/resolv.conf"
mount -t proc proc "$system/proc" 2>/dev/null || mount --bind /proc "$system/proc"
trap 'umount "$system/proc"' EXIT
inside() { chroot "$system" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 sh -euc "$1" </dev/null; }
megabytes() { du -xsm --exclude="$system/proc" "$system" | cut -f1; }
inside 'apt-get update -qq'
ls -l "$system"/packages/*.deb | awk '{ sub(".*/", "", $9); printf "debs: %s %.1f MB\n", $9, $5 / 1e6 }'
for packages in 'libvoxshell0_*' 'libvoxshell-devices0_*' 'voxshell-tools_*' 'libvoxshell-dev_* voxshell-doc_*'; do
    before=$(megabytes) began=$(date +%s.%N)
    inside "cd /packages; set -f; list=; for p in $packages; do set +f; list=\"\$list ./\$(echo \$p)\"; done
        apt-get install -y -qq --no-install-recommends \$list >/dev/null 2>&1"
    echo "debs: apt install $packages: $(echo "$(date +%s.%N) $began" | awk '{ printf "%.1f", $1 - $2 }') s, $(($(megabytes) - before)) MB"
done
inside 'cd /packages; voxshell convert cup.stl --unit mm --voxel 2mm -o assets -q; voxshell verify assets
    voxshell simulate cup_press.scene.json -q | tail -n 1; test -e /usr/lib/udev/rules.d/70-voxshell.rules'
inside 'apt-get install -y -qq --no-install-recommends gcc libc6-dev pkg-config >/dev/null 2>&1
    cd /packages/consumer; cc -o /tmp/feel feel.c $(pkg-config --cflags --libs voxshell-devices); /tmp/feel ../assets/cup.voxmap'
inside 'apt-get purge -y -qq voxshell-tools libvoxshell-dev voxshell-doc libvoxshell-devices0 libvoxshell0 >/dev/null 2>&1
    left=$(find / -xdev -name "*voxshell*" -not -path "/packages*" -not -path "/proc*" -not -path "/var/log/*" -not -path "/var/cache/*"); [ -z "$left" ] || { echo "left behind: $left"; exit 1; }'
echo "debs: installed, used, taken away"
