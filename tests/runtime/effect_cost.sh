#!/bin/sh
# SPDX-License-Identifier: MIT
# A tick that does not ask for an effect takes as many instructions as one of a build without the effect's file
# and its row: within 0.5 %. Arguments: the effect, tick_cost, tick_cost without it, and the other effects, which
# are asked for. With "table" for the effect: what each of the others costs.
effect=$1 whole=$2 without=$3
shift 3
command -v valgrind > /dev/null || { echo "effect_cost: skipped, valgrind is not installed"; exit 77; }
folder=$(mktemp -d) && trap 'rm -rf "$folder"' EXIT

# Instructions of 500 ticks.
count()
{
    valgrind --tool=callgrind --toggle-collect=vxs_servo_tick --callgrind-out-file="$folder/out" "$@" \
        > "$folder/said" 2>&1 || { cat "$folder/said" >&2; return 1; }
    awk '/^summary:|^totals:/ { print $2; exit }' "$folder/out"
}

if [ "$effect" = table ]; then
    bare=$(count "$whole") && echo "no effect: $((bare / 500)) instructions a tick" || exit 1
    for other; do
        own=$(count "$whole" "$other") && echo "$other: $(((own - bare) / 500)) more" || exit 1
    done
    exit 0
fi
if "$without" "$effect" 2> /dev/null; then
    echo "effect_cost: $without has got $effect" >&2
    exit 1
fi
with=$(count "$whole" "$@" "$effect") && unasked=$(count "$whole" "$@") && removed=$(count "$without" "$@") || exit 1
echo "$effect: $((with / 500)) instructions a tick with it, $((unasked / 500)) unasked, $((removed / 500)) removed"
awk -v a="$unasked" -v b="$removed" -v c="$with" \
    'BEGIN { exit !(b > 500 * 100 && c > a && a - b <= 0.005 * b && b - a <= 0.005 * b) }'
