#!/bin/sh
# SPDX-License-Identifier: MIT
# All that one servo can run in its ticks, code and constants, is smaller than 64 KiB: of the kernels for an
# instruction set one (what they fall back to besides, where a map is too large for gathers), and of the bodies
# that an object can be one: a coupling's, or inertia's with a coupling that has none. Arguments: size, then the
# objects in one list with semicolons.
size=$1
IFS=';'
set -- $2
unset IFS
"$size" "$@" | awk '
    NR == 1 { next }
    { all += $1 }
    $NF ~ /contact_channel_avx2\.c/ { sampling = $1; next } # of both that have it
    $NF ~ /contact_avx(2|512)\.c/ { if ($1 > avx) avx = $1; next }
    $NF ~ /contact_(neon|scalar_sum)\.c/ { if ($1 > kernel) kernel = $1; next }
    $NF ~ /coupling_(none|pt2)\.c/ { if ($1 > filter) filter = $1; next }
    $NF ~ /coupling_[a-z0-9_]*\.c/ { if ($1 > body) body = $1; next }
    $NF ~ /effects\/inertia\.c/ { inertia = $1; next }
    { one += $1 }
    END {
        if (avx + sampling > kernel) kernel = avx + sampling
        filter += inertia
        one += kernel + (filter > body ? filter : body)
        print "tick_size: " one + 0 " bytes of " all + 0
        exit !(one > 0 && one < 65536)
    }'
