# SPDX-License-Identifier: GPL-3.0-or-later
"""The programs in samples/ on the assets that their READMEs convert: own_loop and own_device push the sphere into the cup's wall, where what the
loop pushes with must balance the hand."""
import os
import pathlib
import re
import subprocess
import unittest

import command

BUILD = pathlib.Path(os.environ['VOXSHELL_BUILD'])


class Programs(command.CommandTest):
    def pushes(self, name):
        self.run_voxshell('convert', BUILD / 'samples/cup_hold.scene.json', '-o', 'assets', '-q')
        done = subprocess.run([BUILD / 'bin' / f'sample_{name}', 'assets/cup_hold.voxmap', 'assets/cup_hold.pointshell'], cwd=self.folder,
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        loop, hand = map(float, re.search(r'loop pushes with ([-\d.]+) N, the hand with ([-\d.]+) N', done.stdout).groups())
        self.assertGreater(loop, 1)
        self.assertAlmostEqual(loop, hand, delta=0.05)
        return done.stdout

    def test_own_loop(self):
        said = self.pushes('own_loop')
        self.assertLess(float(re.search(r'([\d.]+) mm deep', said)[1]), 1)

    def test_own_device(self):
        self.assertIn('motor at 0.000 N after the end', self.pushes('own_device'))

    def test_refusals(self):
        for name in ('own_loop', 'own_device', 'hvlink_device'):
            done = subprocess.run([BUILD / 'bin' / f'sample_{name}', 'none'], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 1)
            self.assertIn('usage:', done.stderr)


if __name__ == '__main__':
    command.main()
