# SPDX-License-Identifier: GPL-3.0-or-later
"""A disk that fails or fills up, or takes a little at a time, whatever is written: one line, exit code 2, nothing half-written.
And no difference for the language, the time zone or the clock."""
import errno
import shutil
import subprocess

import command
import shapes


class Faults(command.CommandTest):
    @classmethod
    def setUpClass(cls):
        cls.place = command.tempfile.mkdtemp(prefix='voxshell-')
        cls.addClassCleanup(shutil.rmtree, cls.place, ignore_errors=True)
        cls.shim = command.shim('failing_calls.c', cls.place)

    def setUp(self):
        super().setUp()
        shapes.write_stl(self.path('cup.stl'), shapes.cup())
        self.run_voxshell('convert', 'cup.stl', '-o', 'in', '--unit', 'mm', '--voxel', '1mm', '-q')
        self.jobs = {
            'convert': ('cup.stl', '-o', 'out', '--unit', 'mm', '--voxel', '1mm', '-q', '-j1', '--report', 'report.json'),
            'pack': ('in/cup.vdb', '-o', 'packed.voxmap', '-q'),
            'export': ('in/cup.pointshell', '-o', 'points.csv', '-q'),
        }

    def env(self, **more):
        return {'LD_PRELOAD': self.shim, **{k: str(v) for k, v in more.items()}}

    def calls(self, verb, call):
        """How many there are of a call when nothing fails; what was written goes again."""
        before = self.listing()
        self.run_voxshell(verb, *self.jobs[verb], env=self.env(FAULT_CALL=call, FAULT_COUNT=self.path('count')))
        count = int(self.folder.joinpath('count').read_text(encoding='ascii'))
        for name in reversed(self.listing()):
            if name not in before:
                path = self.folder / name
                path.rmdir() if path.is_dir() else path.unlink()
        return count

    def test_each_call_fails(self):
        for verb, arguments in self.jobs.items():
            for call, number in (('write', errno.ENOSPC), ('write', errno.EIO), ('fsync', errno.EIO), ('rename', errno.EIO)):
                count = self.calls(verb, call)
                if call == 'write':
                    self.assertGreater(count, 0, (verb, call))
                for at in sorted({1, 2, (count + 1) // 2, count} & set(range(1, count + 1))):
                    with self.subTest(verb=verb, call=call, at=at, of=count, error=errno.errorcode[number]):
                        self.fails(verb, arguments, FAULT_CALL=call, FAULT_AT=at, FAULT_ERRNO=number)

    def fails(self, verb, arguments, **fault):
        before = self.digests(self.folder)
        done = self.run_voxshell(verb, *arguments, code=2, err=rf'^(voxshell {verb}: error: [^\n]+\n)+$', env=self.env(**fault))
        self.assertRegex(done.stderr, 'No space left|Input/output error')
        after = self.digests(self.folder)
        # What was whole before the fault may stay; nothing is half-written, and no temporary file is left.
        self.assertEqual({k: v for k, v in after.items() if k in before}, before)
        for name in set(after) - set(before):
            self.assertRegex(name, r'^out/cup\.(vdb|voxmap|pointshell)$')
            self.assertEqual(after[name], before['in/' + name.removeprefix('out/')], name)
            self.folder.joinpath(name).unlink()
        shutil.rmtree(self.path('out'), ignore_errors=True)

    def test_a_little_at_a_time(self):
        """Short and interrupted writes: the same bytes."""
        self.run_voxshell('convert', *self.jobs['convert'], env=self.env(FAULT_SHORT=777))
        self.assertEqual(self.digests(self.path('out')), self.digests(self.path('in')))
        self.run_voxshell('pack', *self.jobs['pack'], env=self.env(FAULT_SHORT=100))
        self.run_voxshell('pack', 'in/cup.vdb', '-o', 'again.voxmap', '-q')
        self.assertEqual(self.folder.joinpath('packed.voxmap').read_bytes(), self.folder.joinpath('again.voxmap').read_bytes())

    def test_language_zone_and_clock(self):
        """A language with decimal commas, made for the occasion, a zone of three quarters of an hour."""
        made = subprocess.run(['localedef', '-i', 'de_DE', '-f', 'UTF-8', self.path('de_DE.UTF-8')], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, check=False) if shutil.which('localedef') else None
        if not made or made.returncode not in (0, 1) or not self.folder.joinpath('de_DE.UTF-8').exists():
            self.skipTest('no localedef')
        env = {'LOCPATH': str(self.folder), 'LC_ALL': 'de_DE.UTF-8', 'TZ': 'Asia/Kathmandu'}
        said = [self.run_voxshell('inspect', 'in/cup.pointshell', env=e).stdout for e in ({}, env)]
        self.assertEqual(*said)
        self.run_voxshell('convert', *self.jobs['convert'], '--reproducible', env=env)
        self.assertEqual(self.digests(self.path('out')), self.digests(self.path('in')))
        self.run_voxshell('export', 'in/cup.pointshell', '-o', 'comma.csv', '-q', env=env)
        self.run_voxshell('export', *self.jobs['export'])
        self.assertEqual(self.folder.joinpath('comma.csv').read_bytes(), self.folder.joinpath('points.csv').read_bytes())


if __name__ == '__main__':
    command.main()
