#!/bin/sh
# SPDX-License-Identifier: MIT
# A big-endian target cannot map an asset, and its compiler must say so. Arguments: a C compiler, the formats' include
# folder.
status=0
compile() { printf '#include "voxshell/format/container.h"\n' | "$@" -I"$include" -std=c11 -w -fsyntax-only -xc - 2>&1; }
compiler=$1 include=$2
compile "$compiler" || { echo "refuses_big_endian: the header itself does not compile" >&2; status=1; }
if told=$(compile "$compiler" -U__BYTE_ORDER__ -D__BYTE_ORDER__=__ORDER_BIG_ENDIAN__); then
    echo "refuses_big_endian: a big-endian target is not refused" >&2
    status=1
fi
case $told in
*'#error'*big-endian*) ;;
*) echo "refuses_big_endian: refused for another reason: $told" >&2; status=1 ;;
esac
exit $status
