# SPDX-License-Identifier: GPL-3.0-or-later
"""The samples that are command lines, on the test bed's models."""
import os
import pathlib
import shutil
import subprocess

import command

BUILD = pathlib.Path(os.environ['VOXSHELL_BUILD'])


class Scripts(command.CommandTest):
    def script(self, name, *arguments, models=(), code=0):
        for model in models:
            shutil.copy(BUILD / 'samples' / model, self.folder)
        path = f'{pathlib.Path(command.BIN).parent}:{os.environ["PATH"]}'
        done = subprocess.run([command.SOURCE / 'samples' / name / f'{name}.sh', *arguments], cwd=self.folder, capture_output=True, text=True,
                              timeout=280, env={**os.environ, 'PATH': path})
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def test_convert_part(self):
        said = self.script('convert_part', 'cup.glb', 'out', models=['cup.glb'])
        self.assertIn('closed', said)
        self.assertIn('ok out/cup.pointshell', said)
        with open(self.path('out', 'cup.ply'), 'rb') as file:
            self.assertIn(b'property float nx', file.read(2000))

    def test_convert_part_of_a_file_that_is_none(self):
        pathlib.Path(self.path('none.glb')).write_bytes(b'no glTF')
        self.assertIn('error: none.glb: ', self.script('convert_part', 'none.glb', 'out', code=3))
        self.assertFalse(os.path.exists(self.path('out')))

    def test_peg_in_hole(self):
        if not shutil.which('gnuplot'):
            self.skipTest('no gnuplot')
        said = self.script('peg_in_hole', 'peg', models=['ring.glb', 'peg.glb', 'peg_in_hole.scene.json'])
        patch, average = said.split('peg_average:')
        self.assertNotIn('mean-cancelled', patch)
        self.assertIn('mean-cancelled', average)
        self.assertTrue(os.path.getsize(self.path('peg', 'patch.svg')) and os.path.getsize(self.path('peg', 'average.svg')))

    def test_ship(self):
        os.mkdir(self.path('parts'))
        for part in ('cup.stl', 'sphere.stl'):
            shutil.copy(BUILD / 'samples' / part, self.path('parts'))
        self.assertRegex(self.script('ship', 'parts', 'out'), r'2 built, 0 failed\n(.*\n)*ok out/lab/assets/manifest.json 6 files')
        archive = pathlib.Path(self.path('out', 'assets.tar')).read_bytes()
        self.assertIn('2 up to date', self.script('ship', 'parts', 'out'))
        self.assertEqual(pathlib.Path(self.path('out', 'assets.tar')).read_bytes(), archive)
        with open(self.path('out', 'lab', 'assets', 'cup.voxmap'), 'r+b') as file:
            file.seek(1000)
            file.write(b'?')
        self.run_voxshell('verify', '--manifest', 'out/lab/assets', code=3, err='cup.voxmap: has other content')


if __name__ == '__main__':
    command.main()
