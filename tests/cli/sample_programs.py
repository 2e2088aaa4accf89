# SPDX-License-Identifier: GPL-3.0-or-later
"""The programs in samples/ as their READMEs say: what the loop pushes with balances the hand, contact is an elastic foundation's, a filter and an effect do what
their formulas say."""
import csv
import math
import os
import pathlib
import re
import subprocess

import command

BUILD = pathlib.Path(os.environ['VOXSHELL_BUILD'])


class Programs(command.CommandTest):
    def sample(self, name, *arguments, code=0):
        program = BUILD / 'bin' / f'sample_{name}'
        if not program.exists():
            self.skipTest(f'{name} needs the static library')
        done = subprocess.run([program, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr if code else done.stdout

    def on_the_cup(self, name):
        self.run_voxshell('convert', BUILD / 'samples/cup_hold.scene.json', '-o', 'assets', '-q')
        return self.sample(name, 'assets/cup_hold.plan')

    def pushes(self, name):
        said = self.on_the_cup(name)
        loop, hand = map(float, re.search(r'loop pushes with ([-\d.]+) N, the hand with ([-\d.]+) N', said).groups())
        self.assertGreater(loop, 1)
        self.assertAlmostEqual(loop, hand, delta=0.05)
        return said

    def test_own_loop(self):
        said = self.pushes('own_loop')
        self.assertLess(float(re.search(r'([\d.]+) mm deep', said)[1]), 1)

    def test_own_device(self):
        self.assertIn('motor at 0.000 N after the end', self.pushes('own_device'))

    def test_own_filter(self):
        collision, felt, flags = re.search(r'lab-lag: collision ([\d.]+) N, the hand feels ([\d.]+) N; flags of all ticks 0x(\w+)', self.on_the_cup('own_filter')).groups()
        self.assertGreater(float(felt), 0.5)
        self.assertAlmostEqual(float(collision), float(felt), delta=0.01)  # a low-pass at rest
        self.assertFalse(int(flags, 16) & 1 << 16)

    def test_own_effect(self):
        rows = re.findall(r'([\d.]+) mm: (-?[\d.]+) N', self.on_the_cup('own_effect'))
        self.assertEqual(len(rows), 5)
        for x, force in rows:  # the magnet is at 65 mm, 1 N and 10 mm
            way = (65 - float(x)) / 10
            self.assertAlmostEqual(float(force), 2 * way / (1 + way**2), delta=1e-3, msg=x)

    def test_query_contact(self):
        self.run_voxshell('convert', BUILD / 'samples/cup_hold.scene.json', '-o', 'assets', '-q')
        rows = list(csv.DictReader(self.sample('query_contact', 'assets/cup_hold.voxmap', 'assets/cup_hold.pointshell').splitlines()))
        self.assertEqual(len(rows), 31)
        curvature = math.sqrt((1 / 15 + 1 / 40) * (1 / 15))
        for row in rows:
            depth = 55 - float(row['x_mm'])  # the sphere's radius is 15 mm, the cup's 40 mm
            force = float(row['force_x_n'])
            if depth < 0:
                self.assertEqual((force, row['points']), (0, '0'))
            elif depth > 0.8:  # an elastic foundation's
                expected = 0.3 * math.pi * depth**2 / curvature
                self.assertAlmostEqual(force, expected, delta=0.1 * expected, msg=row)

    def test_refusals(self):
        for name in ('own_loop', 'own_device', 'own_filter', 'own_effect', 'hvlink_device', 'query_contact'):
            self.assertIn('usage:', self.sample(name, 'none', code=1))


if __name__ == '__main__':
    command.main()
