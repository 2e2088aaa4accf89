#!/bin/sh
# SPDX-License-Identifier: MIT
# A tick that does not ask for an effect takes as many instructions as one of a build without the effect's file
# and its row, to ten instructions. Arguments: the effect, tick_cost, tick_cost without it, and the other effects, which
# are asked for. Or "table" and tick_cost: what each effect costs beside a tick with none, for a README. Or "most",
# tick_cost and a number: that many instructions at most in a tick with no effect.
effect=$1 whole=$2
command -v valgrind > /dev/null || { echo "effect_cost: skipped, valgrind is not installed"; exit 77; }
folder=$(mktemp -d) && trap 'rm -rf "$folder"' EXIT

# Instructions of 200 ticks.
count()
{
    valgrind --tool=callgrind --toggle-collect=vxs_servo_tick --callgrind-out-file="$folder/out" "$@" \
        > "$folder/said" 2>&1 || { cat "$folder/said" >&2; return 1; }
    awk '/^summary:|^totals:/ { print $2; exit }' "$folder/out"
}

if [ "$effect" = table ]; then
    bare=$(count "$whole") || exit 1
    echo "| effect | instructions a tick |"
    echo "|---|---|"
    echo "| none | $((bare / 200)) |"
    for other in $("$whole" list); do
        own=$(count "$whole" "$other") && echo "| *$other* | + $(((own - bare) / 200)) |" || exit 1
    done
    exit 0
fi
if [ "$effect" = most ]; then
    bare=$(count "$whole") || exit 1
    echo "$((bare / 200)) instructions a tick, $3 at most"
    [ $((bare / 200)) -le "$3" ] && [ "$bare" -gt 20000 ]
    exit
fi
without=$3
shift 3
if "$without" "$effect" 2> /dev/null; then
    echo "effect_cost: $without has got $effect" >&2
    exit 1
fi
with=$(count "$whole" "$@" "$effect") && unasked=$(count "$whole" "$@") && removed=$(count "$without" "$@") || exit 1
echo "$effect: $((with / 200)) instructions a tick with it, $((unasked / 200)) unasked, $((removed / 200)) removed"
awk -v a="$unasked" -v b="$removed" -v c="$with" \
    'BEGIN { exit !(b > 200 * 100 && c > a && a - b <= 2000 && b - a <= 2000) }'
