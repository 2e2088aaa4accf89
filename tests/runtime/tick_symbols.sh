#!/bin/sh
# SPDX-License-Identifier: MIT
# The tick's objects may call these and nothing else: no allocation, no lock, no system, no
# transcendental function. (__aarch64_ldadd8_relax adds atomically; bcmp is clang's memcmp.) Arguments: nm, then the
# objects, or lists of them with semicolons.
nm=$1
shift
IFS=';'
set -- $*
unset IFS
allowed=' memcpy memset memmove memcmp bcmp sqrt sqrtf floor floorf fabs fabsf fmin fmax trunc _GLOBAL_OFFSET_TABLE_ __stack_chk_fail '
allowed="$allowed __aarch64_ldadd8_relax "
defined=$("$nm" -g --defined-only "$@" | awk 'NF == 3 { print $3 }')
status=0
for symbol in $("$nm" -u "$@" | awk 'NF == 2 { print $2 }' | sort -u); do
    case "$allowed" in *" $symbol "*) continue ;; esac
    if ! echo "$defined" | grep -qx "$symbol"; then
        echo "tick_symbols: the tick calls $symbol" >&2
        status=1
    fi
done
[ -n "$defined" ] || { echo "tick_symbols: no objects" >&2; status=1; }
exit $status
