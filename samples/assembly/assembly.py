#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""An assembly as its batch describes it: each distinct part's map once, each instance where it stands, felt with a ball.

    assembly.py OUT/NAME/assembly.json BALL.pointshell
"""
import json
import pathlib
import sys

import numpy as np
import voxshell as vxs


def main(assembly, ball):
    folder = pathlib.Path(assembly).parent
    tree = json.loads(pathlib.Path(assembly).read_text(encoding="utf-8"))
    maps = [vxs.Voxmap(folder / part["files"]["voxmap"]["path"]) for part in tree["parts"]]
    statics = [(maps[i["part"]], i["position_m"] + i["orientation_wxyz"]) for i in tree["instances"]]
    touch = vxs.Contact(vxs.Pointshell(ball), statics, weighting="area", stiffness=3e8)
    print(f"{len(maps)} maps for {len(statics)} instances")
    path = np.zeros((81, 3))
    path[:, 0] = np.linspace(-0.06, 0.06, 81)  # [m], straight through
    results = touch.evaluate(path)
    touching = np.flatnonzero(results["points"])
    print(f"from {1e3 * path[touching[0], 0]:.1f} to {1e3 * path[touching[-1], 0]:.1f} mm {len(touching)} of {len(path)} places touch, "
          f"{results['points'].max()} points at most")


if __name__ == "__main__":
    main(*sys.argv[1:])
