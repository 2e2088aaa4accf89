#!/bin/sh
# SPDX-License-Identifier: MIT
# Why a peg in a hole wants the law patch and the field distance: peg_in_hole.sh OUT, where peg_in_hole.scene.json is.
set -eu
out=$1

voxshell convert peg_in_hole.scene.json -o "$out"
voxshell simulate peg_in_hole.scene.json --assets "$out" --plot "$out/patch.svg"
sed 's/"law": "patch"/"law": "average"/' peg_in_hole.scene.json >peg_average.scene.json
voxshell simulate peg_average.scene.json --plot "$out/average.svg"
