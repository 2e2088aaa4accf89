#!/bin/sh
# SPDX-License-Identifier: MIT
# hvlink's two ends fit a microcontroller: compiled for size and without a library they are below 6 KiB of code and
# constants, hold no data, and call nothing but what a compiler puts in by itself. Arguments: compiler, size, nm, and
# the project's folder.
set -eu
compiler=$1 size=$2 nm=$3 source=$4
folder=$(mktemp -d) && trap 'rm -rf "$folder"' EXIT
for name in hvlink_protocol hvlink_device; do
    "$compiler" -std=c11 -Os -ffreestanding -I"$source/runtime/include" -I"$source/formats/include" \
        -c "$source/runtime/src/devices/$name.c" -o "$folder/$name.o"
done
for symbol in $("$nm" -u "$folder"/*.o | awk 'NF == 2 { print $2 }' | sort -u); do
    case $symbol in
    memcpy | memset | memmove | _GLOBAL_OFFSET_TABLE_ | __stack_chk_fail) ;;
    *) "$nm" -g --defined-only "$folder"/*.o | grep -qw "$symbol" || { echo "hvlink calls $symbol" >&2; exit 1; } ;;
    esac
done
"$size" "$folder"/*.o | awk 'NR > 1 { text += $1; data += $2 + $3 }
    END { print text + 0 " bytes of code and constants, " data + 0 " of data"; exit !(text > 0 && text < 6144 && data == 0) }'
