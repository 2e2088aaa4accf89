#!/bin/sh
# SPDX-License-Identifier: MIT
# The runtime on AArch64, cross-compiled and emulated, in $VOXSHELL_BUILD/aarch64:
#   aarch64.sh build        builds it, without a fused multiply-add, whose bits would differ; its big-endian
#                           twin is refused
#   aarch64.sh units        its unit tests, with short walks, but for those of real time; what its tick calls
#   aarch64.sh trajectory   the golden wrenches of the fewer poses, on assets of this machine's tool
set -eu
root=/usr/aarch64-linux-gnu
folder=$VOXSHELL_BUILD/aarch64
for program in aarch64-linux-gnu-gcc aarch64-linux-gnu-objdump qemu-aarch64; do
    command -v $program >/dev/null || { echo "skipped: no $program (tests/packages.txt)"; exit 77; }
done
[ -e $root/lib/libc.so ] || { echo "skipped: no C library in $root (tests/packages.txt)"; exit 77; }

case $1 in
build)
    cd "$VOXSHELL_SOURCE"
    cmake --preset runtime-only -B "$folder" -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
        -DCMAKE_C_COMPILER=aarch64-linux-gnu-gcc "-DCMAKE_CROSSCOMPILING_EMULATOR=qemu-aarch64;-L;$root"
    cmake --build "$folder" -j 2
    aarch64-linux-gnu-objdump -d "$folder/runtime/libvoxshell.a" >"$folder/runtime.s"
    grep -q '<probe_neon>:' "$folder/runtime.s" || { echo "aarch64: NEON is not in it" >&2; exit 1; }
    if grep -wE 'fn?m(add|sub)|fml[as]' "$folder/runtime.s"; then
        echo "aarch64: fused multiply-adds" >&2
        exit 1
    fi
    tests/runtime/refuses_big_endian.sh aarch64-linux-gnu-gcc formats/include -mbig-endian
    ;;
units)
    VXS_TEST_BRIEF=1 ctest --test-dir "$folder" --output-on-failure -L unit -LE 'rt|golden'
    ctest --test-dir "$folder" --output-on-failure -R '^tick_(symbols|size)$'
    ;;
trajectory)
    exec python3 "$VOXSHELL_SOURCE/tests/pipeline/contact_trajectory.py" \
        "$VOXSHELL_SOURCE/tests/golden/contact_trajectory.txt" \
        "qemu-aarch64 -L $root '$folder/bin/contact_trajectory'" 10000
    ;;
*)
    sed -n '3,7s/^# //p' "$0" >&2
    exit 1
    ;;
esac
