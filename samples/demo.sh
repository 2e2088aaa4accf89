#!/bin/sh
# SPDX-License-Identifier: MIT
# The main job from nothing: installs what is missing, builds, turns CAD files into haptic assets, feels them on a
# simulated device, and says where the traces and pictures are. Quick the second time. Any folder will do.
set -eu
. "$(dirname "$0")/../tests/setup.sh"

install_packages "for tests/run.sh alone"
configure release release
build release voxshell voxshell_samples

samples=$root/build/release/samples
out=$root/build/demo
PATH=$root/build/release/bin:$PATH
mkdir -p "$out"

say "cup and sphere from glTF (metres) and from STL (millimetres)"
voxshell convert "$samples/cup.glb" "$samples/sphere.glb" --voxel 2mm -o "$out/glb" --force
voxshell convert "$samples/cup.stl" "$samples/sphere.stl" --unit mm --voxel 2mm -o "$out/stl" --force
voxshell verify "$out/glb"
voxshell verify "$out/stl"

assembly=${VOXSHELL_DATA:-$root/../shared/data}/cad/cookiefactory_watertank.glb
if [ -f "$assembly" ]; then
    say "a water tank skid as its makers drew it: 21 instances of 19 parts"
    voxshell convert "$assembly" --voxel 5mm -o "$out/assembly" --force
    voxshell verify "$out/assembly"
fi

for scene in cup_press cup_slide cup_hold peg_in_hole; do
    say "$scene: the simulated hand moves the sphere"
    voxshell convert "$samples/$scene.scene.json" -o "$out/$scene" --force
    voxshell simulate "$samples/$scene.scene.json" --assets "$out/$scene" --explain --force \
        --trace "$out/$scene.csv" --plot "$out/$scene.svg" --plot "$out/$scene.png" >"$out/$scene.txt"
    cat "$out/$scene.txt"
    voxshell view "$samples/$scene.scene.json" "$out/$scene.csv" --assets "$out/$scene" -o "$out/$scene.html" --force
done

say "done"
echo "traces    $out/cup_press.csv $out/cup_slide.csv $out/cup_hold.csv $out/peg_in_hole.csv"
echo "pictures  $out/cup_press.svg $out/cup_slide.svg $out/cup_hold.svg $out/peg_in_hole.svg, and the same as .png"
echo "pages     $out/cup_press.html $out/cup_slide.html $out/cup_hold.html $out/peg_in_hole.html: open them in a browser"
sed -n 's/^ *force *at the hand \([0-9.]* N\) at most.*/peak force at the hand, pressing the cup: \1/p' "$out/cup_press.txt"
