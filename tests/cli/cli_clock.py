# SPDX-License-Identifier: GPL-3.0-or-later
"""The wall clock is stepped forth and back by hours, the time zone changed, files are from 1970 and from 2100, while the servo loop
runs and while files are made: the same rows, the same bytes, the same decisions. Nothing here looks at how long anything takes."""
import json
import os
import pathlib
import shutil
import subprocess
import sys

import command
import shapes

LONG_AGO, FAR_OFF = 0, 4102444800  # 1970 and 2100


class Clock(command.CommandTest):
    @classmethod
    def setUpClass(cls):
        cls.place = command.tempfile.mkdtemp(prefix='voxshell-')
        cls.addClassCleanup(shutil.rmtree, cls.place, ignore_errors=True)
        cls.shim = command.shim('stepped_clock.c', cls.place)

    def setUp(self):
        super().setUp()
        zone = os.path.join(self.place, 'zone')
        self.stepped = {'LD_PRELOAD': self.shim, 'CLOCK_LOOKS': os.path.join(self.place, 'looks'), 'CLOCK_ZONE': zone, 'TZ': f':{zone}'}

    def looks(self):
        """How often the program looked at the monotonic and at the wall clock."""
        return [int(count) for count in pathlib.Path(self.place, 'looks').read_text(encoding='ascii').split()]

    def test_the_clock_is_stepped(self):
        """Else the others would say nothing: for another program an hour passes between two looks, and back."""
        program = 'import time; a = [time.time() for _ in range(3)]; print(round(a[0] - a[1]), round(a[2] - a[1])); time.monotonic()'
        said = subprocess.run([sys.executable, '-S', '-E', '-c', program], env={**os.environ, **self.stepped}, capture_output=True, text=True, check=True)
        self.assertTrue(any(abs(int(way)) >= 3600 for way in said.stdout.split()), said.stdout)
        self.assertGreaterEqual(self.looks()[1], 3)
        self.assertTrue(pathlib.Path(self.place, 'zone').read_bytes().startswith(b'TZif'))

    def test_loop(self):
        subprocess.run([sys.executable, command.SOURCE / 'samples/models/generate.py', self.folder], check=True)
        shutil.copy(command.SOURCE / 'samples/scenes/cup_press.scene.json', self.folder)
        self.run_voxshell('convert', 'cup_press.scene.json', '-o', 'assets', '-q')
        said = {}
        for name, more, env in (('virtual', [], {}), ('steady', ['--realtime'], {}), ('stepped', ['--realtime'], self.stepped)):
            done = self.run_voxshell('simulate', 'cup_press.scene.json', '--assets', 'assets', '--seconds', 1, '--trace', f'{name}.csv', '--record',
                                     f'{name}.rec', '--format', 'json', '-q', *more, env=env)
            said[name] = json.loads(done.stdout)
        monotonic, wall = self.looks()
        self.assertGreater(monotonic, 2000)  # twice a tick
        self.assertLess(wall, 10)  # what a library does as it begins
        for ending in ('csv', 'rec'):
            rows = self.folder.joinpath(f'virtual.{ending}').read_bytes()
            for name in ('steady', 'stepped'):
                self.assertEqual(self.folder.joinpath(f'{name}.{ending}').read_bytes(), rows, f'{name}.{ending}')
        timing = {'tick', 'realtime'}
        self.assertEqual({k: v for k, v in said['stepped'].items() if k not in timing}, {k: v for k, v in said['virtual'].items() if k not in timing})
        self.assertGreater(said['stepped']['contact_ticks'], 100)
        for key in ('p50_ns', 'max_ns'):  # times that an hour more or less went into, or that were negative
            self.assertTrue(0 <= said['stepped']['tick'][key] < 3e12 and 0 <= said['stepped']['realtime']['lateness'][key] < 3e12, said['stepped'])

    def age(self, folder, seconds):
        for path in pathlib.Path(self.path(folder)).rglob('*'):
            os.utime(path, (seconds, seconds))

    def test_files_of_other_times(self):
        """What is up to date is told by contents."""
        for name, radius in (('one', 20), ('two', 15)):
            shapes.write_stl(self.path(f'{name}.stl'), shapes.cup(radius=radius, height=30, wall=3, segments=24))
        self.folder.joinpath('in').mkdir()
        for name in ('one', 'two'):
            self.folder.joinpath(f'{name}.stl').rename(self.path('in', f'{name}.stl'))
        batch = ('batch', 'in', '--unit', 'mm', '--voxel', '2mm')
        self.run_voxshell(*batch, '-o', 'out', out=r'^2 built, 0 failed\n$')
        self.run_voxshell(*batch, '-o', 'stepped', out=r'^2 built, 0 failed\n$', env=self.stepped)
        self.assertLess(self.looks()[1], 100)
        assets = {k: v for k, v in self.digests(self.path('out')).items() if not k.startswith('.')}
        self.assertEqual({k: v for k, v in self.digests(self.path('stepped')).items() if not k.startswith('.')}, assets)
        for inputs in (LONG_AGO, FAR_OFF):
            for outputs in (LONG_AGO, FAR_OFF):
                self.age('in', inputs)
                self.age('out', outputs)
                self.run_voxshell(*batch, '-o', 'out', out=r'^0 built, 2 up to date, 0 failed\n$', env=self.stepped)
        # One that changed and claims to be older than what was made of it.
        shapes.write_stl(self.path('in', 'one.stl'), shapes.cup(radius=21, height=30, wall=3, segments=24))
        self.age('in', LONG_AGO)
        self.age('out', FAR_OFF)
        self.run_voxshell(*batch, '-o', 'out', out=r'^1 built, 1 up to date, 0 failed\n$', env=self.stepped)

    def test_progress(self):
        """Work that is done only grows."""
        shapes.write_stl(self.path('cup.stl'), shapes.cup())
        arguments = ('convert', 'cup.stl', '--unit', 'mm', '--voxel', '0.5mm', '--progress', 'json')
        self.run_voxshell(*arguments, '-o', 'plain')
        done = self.run_voxshell(*arguments, '-o', 'stepped', env=self.stepped)
        self.assertEqual(self.digests(self.path('stepped')), self.digests(self.path('plain')))
        stages = {}
        for line in map(json.loads, done.stderr.splitlines()):
            self.assertGreaterEqual(line['done'], stages.get(line['stage'], 0), line)
            stages[line['stage']] = line['done']
        self.assertGreater(len(stages), 2)
        self.assertLess(self.looks()[1], 10)


if __name__ == '__main__':
    command.main()
