#!/bin/sh
# SPDX-License-Identifier: MIT
# A CAD file becomes a haptic asset that somebody can trust: convert_part.sh FILE.glb OUT
set -eu
part=$1 out=$2

voxshell convert "$part" --voxel auto --dry-run -o "$out"   # what it would take; writes nothing
voxshell convert "$part" --voxel 2mm --channels distance:3 -o "$out"
name=$(basename "$part" .glb)
voxshell verify "$out/$name.pointshell" --against "$part"   # measured again on the mesh, by other code
voxshell inspect "$out/$name.voxmap"
voxshell export "$out/$name.pointshell" -o "$out/$name.ply" # to look at: points with normals
