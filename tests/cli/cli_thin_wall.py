# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's figure 12a, made to hold: a hand pushes the sphere 8 mm past the surface of the cup's 6 mm wall, at 0.1 and 0.3 m/s, on every
simulated device. With a quasi-static coupling that is designed, and depth from layers or distance, nothing goes through and nothing hums."""
import csv
import json
import subprocess
import sys

import command

WALL = 0.006
STEPS = {'touch': 55e-6, 'omni': 55e-6, 'desktop': 23e-6, 'phantom-premium-1.5': 30e-6, 'phantom-premium-3.0': 20e-6, 'falcon': 38e-6,
         'omega-3': 10e-6, 'delta-3': 30e-6, 'inverse3': 10e-6, 'dlr-lwr': 50e-6}


class ThinWall(command.CommandTest):
    def setUp(self):
        super().setUp()
        subprocess.run([sys.executable, command.SOURCE / 'samples/models/generate.py', self.folder], check=True)
        self.scene = json.loads((command.SOURCE / 'samples/scenes/cup_press.scene.json').read_text())

    def push(self, profile, speed, assets):
        reached = 0.5 + 0.028 / speed
        points = self.scene['hand']['path']
        points[1]['t'], points[2]['t'] = f'{reached}s', f'{reached + 1.5}s'
        self.scene.update(device=f'sim:{profile}', rate='4kHz' if profile in ('omega-3', 'delta-3') else '1kHz')
        (self.folder / 'push.scene.json').write_text(json.dumps(self.scene))
        if not (self.folder / assets).exists():
            self.run_voxshell('convert', 'push.scene.json', '-o', assets, '--quiet')
        told = json.loads(self.run_voxshell('simulate', 'push.scene.json', '--assets', assets, '--trace', 'push.csv', '--force', '--format',
                                            'json', '--quiet').stdout)
        with open(self.path('push.csv'), newline='', encoding='utf-8') as file:
            return told, [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]

    def test_holds(self):
        for law, field in (('average', 'layers'), ('gradient', 'distance')):
            self.scene['contact'] = {'law': law, 'field': field, 'weighting': 'area', 'stiffness': '3e8N/m^3'}
            self.scene['coupling'] = {'kind': 'quasi-static', 'design': 'auto', 'assume': 'hand'}
            for profile, step in STEPS.items():
                for speed in (0.1, 0.3):
                    with self.subTest(field=field, profile=profile, speed=speed):
                        told, rows = self.push(profile, speed, field)
                        # The body stays in the outer half of the wall: contact always pushes it out, never through.
                        self.assertLess(told['depth_max_m'], 0.25 * WALL)
                        self.assertNotIn('deep', told['flag_ticks'])
                        self.assertGreaterEqual(min(row['collision_fx_n'] for row in rows), 0)
                        self.assertGreater(rows[-1]['output_fx_n'], 1)
                        last = [row['device_x_m'] for row in rows if row['t_s'] > rows[-1]['t_s'] - 0.3]
                        self.assertLess((max(last) - min(last)) / step, 3)

    def test_paper_does_not(self):
        """The same push with the paper's filter and its one layer: the check above can fail."""
        told, _ = self.push('phantom-premium-1.5', 0.3, 'surface')
        self.assertIn('deep', told['flag_ticks'])


if __name__ == '__main__':
    command.main()
