# SPDX-License-Identifier: GPL-3.0-or-later
"""Each emulated device, with its mass, hand, kinematics, packets and wire, in a loop at 1 kHz on the samples' cup: a hand brings the sphere
6 mm into the cup's floor, and what the motors do balances it (tests/devices/test_emulated.c holds it to that on virtual time, and prints the
figures): device_on_cup.py SAMPLES TEST_EMULATED"""
import os
import pathlib
import subprocess
import sys
import tempfile

FLOOR, RADIUS, CLEARANCE = 0.006, 0.015, 0.004  # of the cup, of the sphere, of test_emulated [m]

samples, program = pathlib.Path(sys.argv[1]), sys.argv[2]
with tempfile.TemporaryDirectory() as folder:
    subprocess.run([os.environ['VOXSHELL'], 'convert', str(samples / 'cup_hold.scene.json'), '-o', folder, '-q'], check=True, stdout=subprocess.DEVNULL)
    assets = [str(next(pathlib.Path(folder).glob(f'*.{kind}'))) for kind in ('voxmap', 'pointshell')]
    told = subprocess.run([program, 'touch', *assets, str(FLOOR + RADIUS + CLEARANCE)], stdout=subprocess.PIPE, text=True, check=True).stdout
print(told, end='')
for device in ('sim', 'hvlink', 'haply', 'falcon', 'spacemouse'):
    assert any(line.split()[0] == device for line in told.splitlines()), device
