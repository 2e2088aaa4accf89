#!/bin/sh
# SPDX-License-Identifier: MIT
# A program on the runtime needs libc, libm and the loader. Argument: the program.
command -v ldd >/dev/null || { echo "skipped: no ldd" >&2; exit 77; }
libraries=$(ldd "$1" | awk '{ print $1 }') || exit 1
[ -n "$libraries" ] || exit 1
for library in $libraries; do
    case ${library##*/} in
    libc.so.* | libm.so.* | ld-linux* | ld64.so.* | linux-vdso.so.* | linux-gate.so.* | libvoxshell.so.*) ;;
    *) echo "links_libc_only: $library" >&2; exit 1 ;;
    esac
done
