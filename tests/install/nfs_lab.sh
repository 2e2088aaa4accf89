#!/bin/sh
# SPDX-License-Identifier: MIT
# Assets on a lab machine's read-only NFS mount: nfs_lab.sh BUILD FOLDER [MIRROR]
# Boots a Debian 12 of its own (made in FOLDER by debootstrap, once; a virtual machine, as not every kernel has NFS)
# that serves a folder by NFS 4.2 and mounts it read-only. There it verifies, reads and simulates assets of BUILD's
# samples, and the server replaces and shortens them under a running loop. Needs root, debootstrap, qemu-system-x86_64
# and e2fsprogs; not part of run.sh. Five minutes the first time, then one.
set -eu
[ $# -ge 2 ] || { sed -n '3,7s/^# //p' "$0" >&2; exit 1; }
[ "$(id -u)" = 0 ] && command -v debootstrap >/dev/null && command -v qemu-system-x86_64 >/dev/null ||
    { echo "nfs_lab: needs root, debootstrap and qemu-system-x86_64" >&2; exit 77; }
build=$(readlink -f "$1")
mkdir -p "$2"
folder=$(readlink -f "$2") system=$folder/system
voxshell=$build/bin/voxshell samples=$build/samples
mirror=${3:-$(apt-get indextargets --format '$(SITE)' | head -n 1)}
[ -e "$system/usr/sbin/rpc.nfsd" ] || debootstrap --variant=minbase \
    --include=linux-image-amd64,nfs-kernel-server,nfs-common,kmod,iproute2 bookworm "$system" "$mirror" \
    >"$folder/debootstrap.log"

rm -rf "$system/lab"
mkdir -p "$system/lab/lib" "$system/lab/served" "$system/lab/other"
cp "$voxshell" "$system/lab/"
ldd "$voxshell" | sed -n 's/.* => \(\/[^ ]*\) .*/\1/p' | xargs -I@ cp -L @ "$system/lab/lib/"
cp "$samples/cup.glb" "$samples/sphere.glb" "$system/lab/"
cd "$system/lab"
"$voxshell" batch cup.glb sphere.glb -o served/parts --voxel 2mm -q
cp "$samples/cup_hold.scene.json" .
"$voxshell" convert cup_hold.scene.json -o served/scene -q >/dev/null
sed -i 's/"2mm"/"3mm"/' cup_hold.scene.json
"$voxshell" convert cup_hold.scene.json -o other -q >/dev/null

cat >lab.sh <<'LAB'
#!/bin/sh
set -u
export PATH=/usr/sbin:/usr/bin:/sbin:/bin LD_LIBRARY_PATH=/lab/lib
say() { echo "nfs_lab: $*"; }
end() { say "$*"; sync; echo o >/proc/sysrq-trigger; sleep 60; }
must() { what=$1; shift; "$@" >/tmp/said 2>&1 && say "ok: $what" || { cat /tmp/said; end "FAILED: $what"; }; }
mount -t proc proc /proc; mount -t sysfs sys /sys; mount -t tmpfs tmpfs /tmp; mount -t tmpfs tmpfs /srv
modprobe nfsd; modprobe nfsv4; mount -t nfsd nfsd /proc/fs/nfsd
ip link set lo up
mkdir -p /run/rpc_pipefs /var/lib/nfs/v4recovery /tmp/net
cp -r /lab/served/. /srv/
exportfs -i -o rw,fsid=0,no_subtree_check,insecure,no_root_squash 127.0.0.1:/srv
rpc.nfsd -N 3 -V 4.2 4; rpc.mountd -N 2 -N 3
must "mounted read-only by NFS 4.2" mount -t nfs4 -o ro,vers=4.2 127.0.0.1:/ /mnt
grep /mnt /proc/mounts
cd /tmp
must "verify --manifest" /lab/voxshell verify --manifest /mnt/parts
must "verify of the parts" /lab/voxshell verify /mnt/parts
must "verify of the scene" /lab/voxshell verify /mnt/scene
run="--seconds 2 -q"
must "simulated from the mount" /lab/voxshell simulate /mnt/scene/cup_hold.plan $run --trace mount.csv
must "simulated from the disk" /lab/voxshell simulate /lab/served/scene/cup_hold.plan $run --trace disk.csv
must "the same trace" cmp mount.csv disk.csv
cd /lab
must "batch finds it up to date" /lab/voxshell batch cup.glb sphere.glb -o /mnt/parts --voxel 2mm
/lab/voxshell batch cup.glb sphere.glb -o /mnt/parts --voxel 3mm --force -q >/tmp/said 2>&1
code=$?
cat /tmp/said
[ $code = 2 ] && say "ok: what would have to be written there fails with 2" || end "FAILED: exit $code for a write"
cd /tmp
# ESTALE and a shorter file both take mapped pages away: the loop may end by its guard, never by a signal.
under() {
    /lab/voxshell simulate /mnt/scene/cup_hold.plan --seconds 5 --realtime --force --trace loop.csv >said 2>&1 &
    loop=$!
    sleep 2
    eval "$2"
    echo 3 >/proc/sys/vm/drop_caches
    wait $loop
    code=$?
    tail -n 3 said
    say "under a running loop $1: exit $code, $(wc -l <loop.csv) lines of trace"
    [ $code -lt 128 ] || end "FAILED: a signal ended the loop"
    rm -rf /srv/scene; cp -r /lab/served/scene /srv/
}
under "all assets are replaced" 'for f in /lab/other/*; do cp $f /srv/new; mv /srv/new /srv/scene/$(basename $f); done'
under "the assets are removed" 'rm -f /srv/scene/*'
under "the voxmap is cut" 'for f in /srv/scene/*.voxmap; do : >$f; done; cat /mnt/scene/*.voxmap | wc -c'
end passed
LAB
chmod +x lab.sh
image=$folder/disk.img
rm -f "$image"
truncate -s 2G "$image"
mkfs.ext4 -q -d "$system" "$image"
# Not KVM: a virtual machine inside one may have a /dev/kvm that hangs.
timeout 900 qemu-system-x86_64 -accel tcg,thread=multi -cpu max -smp 2 -m 1024 -nographic -no-reboot -drive "file=$image,if=virtio,format=raw" \
    -kernel "$(ls "$system"/boot/vmlinuz-*)" -initrd "$(ls "$system"/boot/initrd.img-*)" \
    -append "root=/dev/vda rw console=ttyS0 quiet init=/lab/lab.sh" </dev/null >"$folder/console.log" 2>&1 || true
tr -d '\r' <"$folder/console.log" | grep -a '^nfs_lab\|voxshell\|nfs4 ' || true
grep -aq '^nfs_lab: passed' "$folder/console.log"
