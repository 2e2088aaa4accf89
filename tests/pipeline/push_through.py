# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's figure 12a, made to hold: a hand pushes the sphere 8 mm into the cup's wall of 6 mm, at 0.1 and 0.3 m/s, on every
simulated device: push_through.py SAMPLES

With the scene samples/scenes/cup_hold.scene.json (law patch, a contact as stiff as the device carries in a hand at 6 dB, the filter
designed for that) the device must rest in the wall, which still pushes back. On the way a fast or heavy one may come out of the
far face for a moment: that is printed. With a quasi-static coupling that is designed, the body that feels the contact must never be
deeper than a quarter of the wall, nor be pushed through it. Both must be still to three encoder steps in the end. The paper's own
field, one layer of surface cells, is printed beside them.
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
WAYS = (('pt2', 'patch', 'layers'), ('pt2', 'patch', 'distance'), ('quasi-static', 'average', 'layers'), ('quasi-static', 'gradient', 'distance'),
        ('pt2', 'average', 'surface'))


def run(*arguments):
    return subprocess.run([os.environ['VOXSHELL'], *arguments], stdout=subprocess.PIPE, text=True, check=True).stdout


def stiffness(device, rate):
    """Half of what the device carries in a hand without any filter but the widest [N/m]."""
    told = json.loads(run('design', '--device', f'sim:{device}', '--rate', rate, '--stiffness', '100N/m', '--assume', 'hand', '--format', 'json'))
    return told['k_max_n_per_m']['hand'] / 2


class Push:
    """One run: how far in the device went and came to rest [m], how still [encoder steps], the last force at the hand [N]; how deep what
    feels the contact was [m], and whether it was ever pushed inwards."""

    def __init__(self, scene, folder, assets, speed, step):
        start, end = 0.075, 0.047
        arrives = 0.5 + (start - end) / speed
        scene['hand'] = {'path': [{'t': f'{t}s', 'position': [f'{x}m', '40mm', '0mm']} for t, x in ((0.5, start), (arrives, end))]}
        (folder / 'push.scene.json').write_text(json.dumps(scene), encoding='utf-8')
        told = json.loads(run('simulate', str(folder / 'push.scene.json'), '--assets', str(assets), '--seconds', f'{arrives + 1.5:.3f}',
                              '--force', '--trace', str(folder / 'push.csv'), '--format', 'json', '--quiet'))
        with open(folder / 'push.csv', newline='', encoding='utf-8') as trace:
            rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(trace)]
        x = [row['device_x_m'] for row in rows]
        rest = [row['device_x_m'] for row in rows if row['t_s'] > rows[-1]['t_s'] - REST]
        self.deepest, self.at_rest = TOUCHES - min(x), TOUCHES - x[-1]
        self.still = (max(rest) - min(rest)) / (step * 1e-6)
        self.force = rows[-1]['output_fx_n']
        self.felt, self.is_deep = told['depth_max_m'], 'deep' in told['flag_ticks']
        self.inwards = min(row['collision_fx_n'] for row in rows) < 0

    def holds(self, coupling):
        if self.still >= 3 or self.force < 1:
            return False
        if coupling == 'quasi-static':
            return self.felt < WALL / 4 and not self.is_deep and not self.inwards
        return self.at_rest < WALL

    def __str__(self):
        return (f'device {1e3 * self.deepest:5.2f} mm in at most, {1e3 * self.at_rest:5.2f} at rest; contact {1e3 * self.felt:5.2f} mm deep; '
                f'{self.force:5.3f} N, {self.still:.1f} encoder steps')


def main():
    samples = pathlib.Path(sys.argv[1])
    hold = json.loads((samples / 'cup_hold.scene.json').read_text(encoding='utf-8'))
    failed = 0
    with tempfile.TemporaryDirectory(prefix='voxshell-') as name:
        folder = pathlib.Path(name)
        for model in ('cup.glb', 'sphere.glb'):
            (folder / model).write_bytes((samples / model).read_bytes())
        for coupling, law, field in WAYS:
            scene, assets = json.loads(json.dumps(hold)), folder / field
            scene['contact'].update(law=law, field=field)
            scene['coupling']['kind'] = coupling
            if coupling == 'quasi-static':  # its spring is what the device feels: the contact may be as stiff as it likes
                scene['contact'].update(stiffness='3e8N/m^3')
                del scene['contact']['most_stiffness']
            (folder / 'push.scene.json').write_text(json.dumps(scene), encoding='utf-8')
            run('convert', str(folder / 'push.scene.json'), '-o', str(assets), '--quiet', '--force')
            for device, step in STEPS.items():
                scene.update(device=f'sim:{device}', rate=f'{KILOHERTZ.get(device, 1)}kHz')
                if coupling == 'pt2':
                    scene['contact']['most_stiffness'] = f'{stiffness(device, scene["rate"]):.0f}N/m'
                for speed in (0.1, 0.3):
                    push = Push(scene, folder, assets, speed, step)
                    holds = push.holds(coupling)
                    print(f'{coupling:12} {law}/{field:8} {device:20} {speed} m/s  {push}  {"holds" if holds else "DOES NOT HOLD"}', flush=True)
                    failed += field != 'surface' and not holds
    sys.exit(f'{failed} do not hold' if failed else 0)


if __name__ == '__main__':
    main()
