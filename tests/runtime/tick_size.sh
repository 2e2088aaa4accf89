#!/bin/sh
# SPDX-License-Identifier: MIT
# All that runs in a tick, code and constants, is smaller than 64 KiB. Arguments: size, then the objects in one list
# with semicolons.
size=$1
IFS=';'
set -- $2
unset IFS
text=$("$size" "$@" | awk 'NR > 1 { sum += $1 } END { print sum + 0 }')
echo "tick_size: $text bytes"
[ "$text" -gt 0 ] && [ "$text" -lt 65536 ]
