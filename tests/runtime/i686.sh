#!/bin/sh
# SPDX-License-Identifier: MIT
# The runtime with words of 32 bits, cross-compiled and static, in $VOXSHELL_BUILD/i686: its unit tests with short walks,
# and the golden files. A size that does not fit is refused, not cut. Arithmetic is SSE2's: the bits are those of x86-64.
set -eu
folder=$VOXSHELL_BUILD/i686
command -v i686-linux-gnu-gcc >/dev/null || { echo "skipped: no i686-linux-gnu-gcc (tests/packages.txt)"; exit 77; }
[ -e /usr/i686-linux-gnu/lib/libc.a ] || { echo "skipped: no C library for i686 (tests/packages.txt)"; exit 77; }
cd "$VOXSHELL_SOURCE"
cmake --preset runtime-only -B "$folder" -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=i686 \
    -DCMAKE_C_COMPILER=i686-linux-gnu-gcc "-DCMAKE_C_FLAGS=-msse2 -mfpmath=sse" -DCMAKE_EXE_LINKER_FLAGS=-static \
    -DVOXSHELL_SAMPLES=OFF
cmake --build "$folder" -j 2
VXS_TEST_BRIEF=1 exec ctest --test-dir "$folder" --output-on-failure -L 'unit|golden|fuzz' -LE rt -E 'refuses_big_endian|mutate_checks|test_readers'
