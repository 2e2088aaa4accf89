#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plans an experiment on felt stiffness: which walls can each device present, before anybody sits down at one.

    experiment.py cup_hold.plan -o stimuli        stimuli.csv, and stimuli.svg where gnuplot is

The hand presses the sphere into the cup's wall and rests. For each device and each stiffness of the coupling it notes what a
hand would feel: the force over the way from the first touch on (felt), how much it trembles at rest, and whether the device's
limit cut it. A stimulus is good if felt is what was asked for and nothing trembles.
"""
import argparse
import csv
import pathlib
import shutil
import subprocess

import numpy as np
import voxshell as vxs

DEVICES = ("touch", "phantom-premium-1.5", "omega-3")
NOISE = 20e-6  # of each axis that is measured [m]
STIFFNESSES = (100, 200, 400, 600, 800, 1200, 1600, 2400)  # [N/m]


def press(plan, device, stiffness):
    """One press: what is felt [N/m], what trembles [N], the share of ticks that were clamped."""
    config = plan.config()
    config.coupling.stiffness = stiffness
    rows = plan.simulate(config, device=f"sim:{device}", noise=NOISE)
    x, force = rows["pose"]["position"][:, 0], rows["command"]["force"][:, 0]
    touch = np.flatnonzero(rows["points"])[0]
    rest = rows["time_ns"] > rows["time_ns"][-1] - 0.5e9
    clamped = (rows["flags"] & vxs.ServoFlag.SATURATED != 0).mean()
    return force[rest].mean() / (x[touch] - x[rest].mean()), force[rest].std(), clamped


def plot(table, picture):
    lines = ", ".join(f"'< grep ^{device}, {table}' using 2:3 with linespoints pt 7 title '{device}'" for device in DEVICES)
    script = f"""set terminal svg size 640,440 font 'sans,13' background 'white'; set output '{picture}'; set datafile separator ','; set key left top
        set xlabel 'asked for [N/m]'; set ylabel 'felt [N/m]'; set grid; set xrange [0:2500]; set yrange [0:2500]
        plot x with lines lc 'gray' title 'as asked', {lines}"""
    subprocess.run(["gnuplot"], input=script, text=True, check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plan")
    parser.add_argument("-o", default="stimuli", help="name of the table and the picture, without an ending")
    options = parser.parse_args()
    plan, table = vxs.Plan(options.plan), pathlib.Path(options.o + ".csv")
    with open(table, "w", encoding="utf-8", newline="") as file:
        write = csv.writer(file).writerow
        write(("device", "asked_n_per_m", "felt_n_per_m", "trembles_n", "clamped_share"))
        for device in DEVICES:
            good = []
            for stiffness in STIFFNESSES:
                felt, trembles, clamped = press(plan, device, stiffness)
                write((device, stiffness, f"{felt:.1f}", f"{trembles:.4f}", f"{clamped:.3f}"))
                if abs(felt / stiffness - 1) < 0.1 and trembles < 0.05 and not clamped:
                    good.append(stiffness)
            print(f"{device}: {', '.join(map(str, good)) or 'none'} N/m" + (" are felt as asked" if good else " is felt as asked"))
    print(table)
    if shutil.which("gnuplot"):
        plot(table, options.o + ".svg")
        print(options.o + ".svg")


if __name__ == "__main__":
    main()
