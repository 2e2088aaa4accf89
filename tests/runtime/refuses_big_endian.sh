#!/bin/sh
# SPDX-License-Identifier: MIT
# A big-endian target cannot map an asset, and its compiler must say so. Arguments: a C compiler, the formats' include
# folder, and what makes the compiler's target big-endian, if it can be (else a macro says that it is).
compiler=$1 include=$2 big=${3:--D__BYTE_ORDER__=__ORDER_BIG_ENDIAN__}
compile() { printf '#include "voxshell/format/container.h"\n' | "$compiler" "$@" -I"$include" -std=c11 -ffreestanding -w -fsyntax-only -xc - 2>&1; }

compile || { echo "refuses_big_endian: the header itself does not compile" >&2; exit 1; }
if told=$(compile "$big"); then
    echo "refuses_big_endian: a big-endian target is not refused" >&2
    exit 1
fi
case $told in
*'#error'*big-endian*) ;;
*) echo "refuses_big_endian: refused for another reason: $told" >&2; exit 1 ;;
esac
