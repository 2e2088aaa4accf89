#!/bin/sh
# SPDX-License-Identifier: MIT
# A codec under libFuzzer with AddressSanitizer and UBSan: so many executions, or so many seconds, whichever ends
# first; then its corpus, the smallest that reaches as much.
#     tests/fuzz/long.sh NAME [EXECUTIONS [SECONDS [FOLDER]]]      as: long.sh hvlink 100000000 3600
# Needs clang with its sanitizers' runtime (Debian: clang-14 libclang-rt-14-dev). Ends with 0 without a finding.
set -eu
name=$1 executions=${2:-100000000} seconds=${3:-3600}
source=$(cd "$(dirname "$0")/../.." && pwd)
folder=${4:-$source/build/fuzz/$name}
clang=$(command -v clang-14 || command -v clang || true)
[ -n "$clang" ] || { echo "no clang here" >&2; exit 77; }
case $name in
falcon_kinematics) most=30 ;; # all that it reads
replay) most=1024 ;;          # three rows of a recording
*) most=512 ;;
esac
mkdir -p "$folder/corpus" "$folder/least"
cd "$source"
files=
for file in runtime/src/devices/*_protocol.c runtime/src/devices/*_kinematics.c runtime/src/devices/hvlink_device.c \
    runtime/src/devices/replay.c runtime/src/devices/replay_setup.c runtime/src/pose.c runtime/src/device.c \
    runtime/src/device_setup.c runtime/src/crc32.c; do files="$files $file"; done
flags="-std=c11 -O2 -g -ffp-contract=off -fno-sanitize-recover=all -Iruntime/src -Iruntime/include -Iformats/include"
# shellcheck disable=SC2086
"$clang" $flags -fsanitize=address,undefined "tests/fuzz/fuzz_$name.c" tests/fuzz/fuzz_driver.c $files -lm -o "$folder/seeds"
# shellcheck disable=SC2086
"$clang" $flags -fsanitize=fuzzer,address,undefined "tests/fuzz/fuzz_$name.c" $files -lm -o "$folder/fuzz"
"$folder/seeds" seeds "$folder/corpus"
[ ! -d "tests/fuzz/codecs/$name" ] || cp "tests/fuzz/codecs/$name"/* "$folder/corpus"
"$folder/fuzz" "$folder/corpus" -runs="$executions" -max_total_time="$seconds" -max_len="$most" -timeout=60 \
    -artifact_prefix="$folder/finding-" -verbosity=0 -print_final_stats=1
"$folder/fuzz" -merge=1 "$folder/least" "$folder/corpus" -max_len="$most" -verbosity=0
