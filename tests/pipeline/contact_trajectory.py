#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrenches are the same bits with every kernel and every culling, and the golden ones:
contact_trajectory.py GOLDEN PROGRAM [--write]. PROGRAM may be a command of several words (an emulator's)."""
import os
import shlex
import subprocess
import sys
import tempfile

POSES = "100000"


def main(golden, program, *rest):
    voxshell, samples = os.environ["VOXSHELL"], os.path.join(os.environ["VOXSHELL_BUILD"], "samples")
    with tempfile.TemporaryDirectory() as folder:
        for part in ("cup.glb", "sphere.glb"):
            subprocess.run([voxshell, "convert", os.path.join(samples, part), "-o", folder, "--voxel", "1mm", "--channels",
                            "distance:3", "--quiet"], check=True, stdout=subprocess.DEVNULL)
        told = subprocess.run([*shlex.split(program), os.path.join(folder, "cup.voxmap"), os.path.join(folder, "sphere.pointshell"),
                               POSES], check=True, stdout=subprocess.PIPE, text=True).stdout
    print(told, end="")
    if "--write" in rest:
        with open(golden, "w", encoding="utf-8") as file:
            file.write(told)
    with open(golden, encoding="utf-8") as file:
        assert file.read() == told, f"not the wrenches of {golden}"


if __name__ == "__main__":
    main(*sys.argv[1:])
