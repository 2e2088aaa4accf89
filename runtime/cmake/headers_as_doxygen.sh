#!/bin/sh
# SPDX-License-Identifier: MIT
# A header with its comments marked for doxygen: of the file, above a declaration, behind a member.
exec sed -E -e '1,/\*\//{1s,^/\* SPDX.*$,/** @file,;1!b}' -e 's,^(/\*)( |$),/**\2,' \
    -e 's,^(.*[^[:space:]].*[;\,({] *)/\* ,\1/**< ,' -e 's,^( +[A-Z0-9_]+( = [^\,/]*)?) +/\* ,\1 /**< ,' "$1"
