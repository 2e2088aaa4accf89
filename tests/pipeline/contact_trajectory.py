#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrenches are the same bits with every kernel and every culling, and the golden ones:
contact_trajectory.py GOLDEN PROGRAM [POSES|--write]. PROGRAM may be a command of several words (an emulator's, which
has time for the fewer POSES only)."""
import os
import shlex
import subprocess
import sys
import tempfile

POSES = ("10000", "100000")


def main(golden, program, choice=None):
    voxshell, samples = os.environ["VOXSHELL"], os.path.join(os.environ["VOXSHELL_BUILD"], "samples")
    with tempfile.TemporaryDirectory() as folder:
        for part in ("cup.glb", "sphere.glb"):
            subprocess.run([voxshell, "convert", os.path.join(samples, part), "-o", folder, "--voxel", "1mm", "--channels",
                            "layers:3,distance:3", "--quiet"], check=True, stdout=subprocess.DEVNULL)
        assets = [os.path.join(folder, "cup.voxmap"), os.path.join(folder, "sphere.pointshell")]
        told = [subprocess.run([*shlex.split(program), *assets, poses], check=True, stdout=subprocess.PIPE, text=True).stdout
                for poses in ([choice] if choice in POSES else POSES)]
    print("".join(told), end="")
    if choice == "--write":
        with open(golden, "w", encoding="utf-8") as file:
            file.writelines(told)
    with open(golden, encoding="utf-8") as file:
        pinned = file.read()
    assert all(part and part in pinned for part in told), f"not the wrenches of {golden}"


if __name__ == "__main__":
    main(*sys.argv[1:])
