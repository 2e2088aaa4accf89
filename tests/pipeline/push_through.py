# SPDX-License-Identifier: GPL-3.0-or-later
"""A hand pushes 8 mm past the cup's wall of 6 mm, on every simulated device: push_through.py SAMPLES

The scene is samples/scenes/cup_hold.scene.json: law patch, a filter designed for a hand, and a contact as stiff as the design
carries at 6 dB. At 0.1 and 0.3 m/s, with the fields layers and distance, the sphere must rest in the wall (its deepest
point not beyond the other face, and the wall still pushing back), still to three encoder steps. A heavy device may run farther in
before it is pushed back: that is printed. The paper's own field, one layer of surface cells, is printed beside it.
"""
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile

WALL, TOUCHES, REST = 0.006, 0.055, 0.3  # [m], x of the device where the sphere touches [m], the run's last seconds
STEPS = {'touch': 55, 'omni': 55, 'desktop': 23, 'phantom-premium-1.5': 30, 'phantom-premium-3.0': 20, 'falcon': 38,  # encoder [um]
         'omega-3': 10, 'delta-3': 30, 'inverse3': 10, 'dlr-lwr': 50}
KILOHERTZ = {'omega-3': 4, 'delta-3': 4}


def run(*arguments):
    return subprocess.run([os.environ['VOXSHELL'], *arguments], stdout=subprocess.PIPE, text=True, check=True).stdout


def stiffness(device, rate):
    """Half of what the device carries in a hand without any filter but the widest [N/m]."""
    told = json.loads(run('design', '--device', f'sim:{device}', '--rate', rate, '--stiffness', '100N/m', '--assume', 'hand', '--format', 'json'))
    return told['k_max_n_per_m']['hand'] / 2


class Push:
    """One run: how far in the sphere went and came to rest [m], how still [encoder steps], the last force at the hand [N]."""

    def __init__(self, scene, folder, assets, speed, kilohertz, step):
        start, end = 0.075, 0.047
        arrives = 0.5 + (start - end) / speed
        scene['hand'] = {'path': [{'t': f'{t}s', 'position': [f'{x}m', '40mm', '0mm']} for t, x in ((0.5, start), (arrives, end))]}
        file = folder / 'push.scene.json'
        file.write_text(json.dumps(scene), encoding='utf-8')
        run('simulate', str(file), '--assets', str(assets), '--seconds', f'{arrives + 1.5:.3f}', '--force', '--trace', str(folder / 'push.csv'))
        with open(folder / 'push.csv', newline='', encoding='utf-8') as trace:
            rows = list(csv.DictReader(trace))
        x = [float(row['device_x_m']) for row in rows]
        rest = x[-int(REST * 1000 * kilohertz):]
        self.deepest, self.at_rest = TOUCHES - min(x), TOUCHES - x[-1]
        self.still = (max(rest) - min(rest)) / (step * 1e-6)
        self.force = float(rows[-1]['output_fx_n'])

    def holds(self):
        return self.at_rest < WALL and self.force > 0 and self.still < 3

    def __str__(self):
        return (f'deepest {1e3 * self.deepest:6.2f} mm, at rest {1e3 * self.at_rest:6.2f} mm, {self.force:6.3f} N, '
                f'{self.still:.1f} encoder steps')


def main():
    samples = pathlib.Path(sys.argv[1])
    hold = json.loads((samples / 'cup_hold.scene.json').read_text(encoding='utf-8'))
    failed = 0
    with tempfile.TemporaryDirectory(prefix='voxshell-') as name:
        folder = pathlib.Path(name)
        for model in ('cup.glb', 'sphere.glb'):
            (folder / model).write_bytes((samples / model).read_bytes())
        for field, law in (('layers', 'patch'), ('distance', 'patch'), ('surface', 'average')):
            scene, assets = json.loads(json.dumps(hold)), folder / field
            scene['contact'].update(law=law, field=field)
            (folder / 'push.scene.json').write_text(json.dumps(scene), encoding='utf-8')
            run('convert', str(folder / 'push.scene.json'), '-o', str(assets), '--quiet')
            for device, step in STEPS.items():
                kilohertz = KILOHERTZ.get(device, 1)
                scene.update(device=f'sim:{device}', rate=f'{kilohertz}kHz')
                scene['contact']['most_stiffness'] = f'{stiffness(device, scene["rate"]):.0f}N/m'
                for speed in (0.1, 0.3):
                    push = Push(scene, folder, assets, speed, kilohertz, step)
                    told = 'holds' if push.holds() else 'DOES NOT HOLD'
                    print(f'{law}/{field:8} {device:20} {scene["contact"]["most_stiffness"]:8} {speed} m/s  {push}  {told}', flush=True)
                    failed += field != 'surface' and not push.holds()
    sys.exit(f'{failed} do not hold' if failed else 0)


if __name__ == '__main__':
    main()
