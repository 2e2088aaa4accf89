#!/bin/sh
# SPDX-License-Identifier: MIT
# Assets for a machine in the laboratory: ship.sh PARTS-FOLDER OUT. What is carried over is one file.
set -eu
parts=$1 out=$2

# At the desk: convert what changed, with a manifest of sizes and hashes, and pack it. The same input gives the same bytes.
voxshell batch "$parts" --unit mm --voxel 2mm -o "$out/assets" --archive "$out/assets.tar"

# In the laboratory: unpack, and verify that every file is there and the same.
mkdir -p "$out/lab"
tar -xf "$out/assets.tar" -C "$out/lab"
voxshell verify --manifest "$out/lab/assets"
