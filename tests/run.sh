#!/bin/sh
# SPDX-License-Identifier: MIT
# Passes the tests from nothing: installs what is missing, builds, tests. Quick the second time. Any folder will do.
set -eu
. "$(dirname "$0")/setup.sh"

test_in() {
    say "testing build/$1"
    ctest --test-dir "$root/build/$1" --output-on-failure -j "$jobs"
}

install_packages

# The runtime with a C compiler and nothing else, then the same under AddressSanitizer and UBSan.
build_in runtime-only runtime-only
test_in runtime-only
build_in runtime-dev dev -DVOXSHELL_TOOLS=OFF
test_in runtime-dev

build_in release release
test_in release
