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
configure runtime-only runtime-only
build runtime-only
test_in runtime-only
configure runtime-dev dev -DVOXSHELL_TOOLS=OFF
build runtime-dev
test_in runtime-dev

configure release release
build release
test_in release

# Another build type gives the same wrenches to the last bit.
say "the golden wrenches from build/runtime-dev"
VOXSHELL=$root/build/release/bin/voxshell VOXSHELL_BUILD=$root/build/release \
    python3 "$root/tests/pipeline/contact_trajectory.py" "$root/tests/golden/contact_trajectory.txt" \
    "$root/build/runtime-dev/bin/contact_trajectory" 10000
