# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell batch where something is wrong: disks that are full or may only be read, inputs that vanish or change, caches that are damaged, parts
that failed before. One line, the right code, nothing lost."""
import contextlib
import json
import os
import pathlib
import shutil
import subprocess
import unittest

import command
import schema
import shapes

MM = ('--unit', 'mm', '--voxel', '2mm')
SCHEMAS = pathlib.Path(__file__).parents[2] / 'formats' / 'schema'


class Faults(command.CommandTest):
    def stl(self, *name, radius=20, segments=24):
        path = pathlib.Path(self.path(*name))
        path.parent.mkdir(parents=True, exist_ok=True)
        shapes.write_stl(str(path), shapes.cup(radius=radius, height=2 * radius, wall=3, segments=segments))

    def batch(self, *arguments, **more):
        return self.run_voxshell('batch', *arguments, **more)

    def results(self, folder):
        return {name: digest for name, digest in self.digests(self.path(folder)).items() if not name.startswith('.voxshell-cache')}

    @contextlib.contextmanager
    def disk(self, name, size):
        """A file system of its own; skipped where that is not permitted."""
        os.makedirs(self.path(name), exist_ok=True)
        if os.geteuid() != 0 or subprocess.run(['mount', '-t', 'tmpfs', '-o', f'size={size}', 'none', self.path(name)], capture_output=True, check=False).returncode:
            raise unittest.SkipTest('a file system cannot be mounted here')
        try:
            yield
        finally:
            subprocess.run(['umount', '-l', self.path(name)], check=True)

    def only_read(self, name, yes=True):
        subprocess.run(['mount', '-o', f'remount,{"ro" if yes else "rw"}', self.path(name)], check=True)

    def parts(self, count=6):
        for n in range(count):
            self.stl('in', f'{n}.stl', radius=12 + 2 * n)
        self.batch('in', '-o', 'whole', *MM, '-q')
        return self.results('whole')

    def test_a_full_disk(self):
        whole = self.parts()
        needed = sum(p.stat().st_size for p in pathlib.Path(self.path('whole')).glob('*.*')) // 1024
        for share in (0.1, 0.5, 0.9):  # results and cache are one file: hard links
            with self.disk('small', f'{int(needed * share)}k'):
                done = self.batch('in', '-o', 'small/out', *MM, code=2)
                # Where the last result just fits, it is the cache's entry beside it that does not.
                lines = [line for line in done.stderr.splitlines() if line != 'voxshell batch: warning: small/out/.voxshell-cache: results are not stored: No space left on device']
                self.assertGreater(len(lines), 0)
                for line in lines:
                    self.assertRegex(line, '^voxshell batch: error: .*No space left on device$')
                there = self.results('small/out') if os.path.exists(self.path('small/out')) else {}
                for name, digest in there.items():
                    if name != 'manifest.json':
                        self.assertEqual(digest, whole[name], name)
                subprocess.run(['mount', '-o', 'remount,size=50m', self.path('small')], check=True)
                self.batch('in', '-o', 'small/out', *MM)
                self.assertEqual(self.results('small/out'), whole)

    def test_a_full_disk_under_the_cache(self):
        whole = self.parts(3)
        with self.disk('small', '64k'):
            done = self.batch('in', '-o', 'out', *MM, '--cache', 'small/cache', '--report', 'report.json', out='^3 built, 0 failed\n$')
            self.assertEqual(done.stderr, 'voxshell batch: warning: small/cache: results are not stored: No space left on device\n')
            self.assertIn('cache-takes-nothing', [warning['code'] for warning in self.load('report.json')['warnings']])
            self.assertEqual(self.results('out'), whole)
            self.run_voxshell('verify', '--manifest', 'out', '-q')

    def test_a_target_that_may_only_be_read(self):
        whole = self.parts(2)
        with self.disk('disk', '50m'):
            self.batch('in', '-o', 'disk/out', *MM, '-q')
            self.only_read('disk')
            self.batch('in', '-o', 'disk/out', *MM, out='^0 built, 2 up to date, 0 failed\n$', err='')
            self.run_voxshell('verify', '--manifest', 'disk/out', '-q')
            self.stl('in', '0.stl', radius=30)
            done = self.batch('in', '-o', 'disk/out', *MM, code=2, out='^0 built, 1 up to date, 1 failed\n$')
            self.assertRegex(done.stderr, '^voxshell batch: error: disk/out/0.vdb: Read-only file system\n$')
            self.refused(2, 'disk/other.*Read-only', 'in', '-o', 'disk/other', *MM, verb='batch')
            self.assertEqual(self.results('disk/out'), whole)
            self.only_read('disk', False)
            self.batch('in', '-o', 'disk/out', *MM, out='^1 built, 1 up to date, 0 failed\n$')

    def test_a_cache_that_may_only_be_read(self):
        whole = self.parts(3)
        with self.disk('disk', '50m'):
            os.rename(self.path('in', '2.stl'), self.path('2.stl'))
            self.batch('in', '-o', 'out', *MM, '--cache', 'disk/cache', '-q')
            os.rename(self.path('2.stl'), self.path('in', '2.stl'))
            shutil.rmtree(self.path('out'))
            self.only_read('disk')
            before = self.listing(self.path('disk'))
            done = self.batch('in', '-o', 'out', *MM, '--cache', 'disk/cache', out='^1 built, 2 from the cache, 0 failed\n$')
            self.assertEqual(done.stderr, 'voxshell batch: warning: disk/cache: results are not stored: Read-only file system\n')
            self.assertEqual(self.results('out'), whole)
            self.assertEqual(self.listing(self.path('disk')), before)
            # A damaged entry cannot be taken away: it is made anew beside it.
            self.only_read('disk', False)
            for stored in pathlib.Path(self.path('disk', 'cache')).rglob('voxmap'):
                stored.write_bytes(b'?' + stored.read_bytes()[1:])
            self.only_read('disk')
            shutil.rmtree(self.path('out'))
            self.batch('in', '-o', 'out', *MM, '--cache', 'disk/cache', out='^3 built, 0 failed\n$')
            self.assertEqual(self.results('out'), whole)

    def test_an_input_that_vanishes_or_changes_on_its_way(self):
        """The first line of progress is of the heaviest part: all are planned, the others wait."""
        for change, fact in ((os.unlink, 'cannot read: No such file'), (lambda path: shapes.write_stl(path, shapes.box()), 'changed while the batch ran: run it again')):
            shutil.rmtree(self.path(''))
            self.stl('in', 'heavy.stl', radius=40, segments=96)
            for n in range(40):
                self.stl('in', f'{n}.stl', radius=10 + n / 10)
            process = subprocess.Popen([command.BIN, 'batch', 'in', '-o', 'out', *MM, '-j1', '--progress', 'json'], cwd=self.folder, stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE, text=True)
            first = json.loads(process.stderr.readline())
            self.assertEqual(first['part'], 'heavy')
            change(self.path('in', '9.stl'))  # equally heavy ones go in their order by name: this one is the last
            out, err = process.communicate(timeout=120)
            errors = [line for line in err.splitlines() if not line.startswith('{')]
            self.assertEqual(process.returncode, 2, out + err)
            self.assertEqual(len(errors), 1, err)
            self.assertRegex(errors[0], f'^voxshell batch: error: in/9.stl: {fact}')
            self.assertEqual(out, '40 built, 1 failed\n')
            self.run_voxshell('verify', '--manifest', 'out', '-q')
            if change is not os.unlink:  # nothing was stored under the name of what it was
                self.batch('in', '-o', 'out', *MM, out='^1 built, 40 up to date, 0 failed\n$')
                self.run_voxshell('convert', 'in/9.stl', '-o', 'alone', *MM, '-q')
                self.assertEqual(self.digests(self.path('alone'))['9.voxmap'], self.digests(self.path('out'))['9.voxmap'])

    def test_a_damaged_entry(self):
        whole = self.parts(1)
        self.batch('in', '-o', 'out', *MM, '--cache', 'cache', '-q')
        entry = next(pathlib.Path(self.path('cache')).rglob('entry.json'))
        text = entry.read_text(encoding='utf-8')
        for broken in ('', '{', '[]', '{"entry": 3, "sha256": 3}', text[:-20], text.replace('"triangles": ', '"triangles": 9').replace('"triangles":', '"triangles":9'),
                       text.replace('"name"', '"mane"'), text.replace('voxmap', '../../x')):
            self.assertNotEqual(broken, text)
            entry.write_text(broken, encoding='utf-8')
            shutil.rmtree(self.path('out'))
            self.batch('in', '-o', 'out', *MM, '--cache', 'cache', '--report', 'report.json', '--force', out='^1 built, 0 failed\n$', err='')
            self.assertEqual(self.results('out'), whole)
            self.assertEqual(entry.read_text(encoding='utf-8'), text)
        os.truncate(entry.parent / 'vdb', 50)
        shutil.rmtree(self.path('out'))
        self.batch('in', '-o', 'out', *MM, '--cache', 'cache', out='^1 built, 0 failed\n$', err='')
        self.assertEqual(self.results('out'), whole)

    def test_a_part_that_failed_before(self):
        os.makedirs(self.path('in'))
        shapes.write_stl(self.path('in', 'block.stl'), shapes.box(20, 30, 40))
        shapes.write_stl(self.path('in', 'sheet.stl'), [((0, 0, 0), (10, 0, 0), (0, 10, 0))])
        shutil.copy(self.path('in', 'sheet.stl'), self.path('in', 'same sheet.stl'))
        pathlib.Path(self.path('in', 'bad.stl')).write_bytes(b'solid x\nfacet')
        strict = ('in', '-o', 'out', *MM, '--strict', '--reproducible', '--max-memory', '1G')
        first = self.batch(*strict, '--report', '1.json', code=4, out='1 built, 3 failed')
        self.assertNotIn('as before', first.stderr)
        again = self.batch(*strict, '--report', '2.json', code=4, out='0 built, 1 up to date, 3 failed')
        self.assertEqual(sorted(line.replace(' (as before; --retry-failed tries again)', '') for line in again.stderr.splitlines()), sorted(first.stderr.splitlines()))
        self.assertEqual(again.stderr.count('as before'), 3)
        self.assertEqual(self.load('1.json')['failed'], self.load('2.json')['failed'])
        self.assertEqual([(each['path'], each['code']) for each in self.load('2.json')['failed']], [('bad', 3), ('same sheet', 4), ('sheet', 4)])
        tried = self.batch(*strict, '--retry-failed', code=4)
        self.assertNotIn('as before', tried.stderr)
        # What --strict refuses may depend on the memory: with another budget it is tried again; bad bytes stay bad.
        other = self.batch(*strict[:-1], '2G', code=4)
        self.assertEqual([line for line in other.stderr.splitlines() if 'as before' in line], [line for line in other.stderr.splitlines() if 'bad.stl' in line])
        self.batch('in', '-o', 'out', *MM, code=3, out='^2 built, 1 from the cache, 1 failed\n$')  # other options
        self.stl('in', 'bad.stl', radius=9)
        self.batch('in', '-o', 'out', *MM, out='^1 built, 3 up to date, 0 failed\n$')

    def test_a_dry_run(self):
        self.stl('in', 'cup.stl')
        self.stl('in', 'same.stl')
        self.stl('in', 'wide.stl', radius=25)
        before = self.listing()
        done = self.batch('in', '-o', 'out', *MM, '--dry-run')
        self.assertRegex(done.stdout, r'^cup: .* triangles, about .* of memory.*\nwide: .*\n2 to build, 1 from the cache, 0 failed: up to .*iB of memory for a part, .* of files, about .* s on \d+ threads\n$')
        self.assertEqual(self.listing(), before)
        self.batch('in', '-o', 'out', *MM, '--cache', 'cache', '-q')
        os.unlink(self.path('out', 'same.voxmap'))
        self.stl('in', 'new.stl', radius=30)
        pathlib.Path(self.path('in', 'bad.stl')).write_bytes(b'solid x\nfacet')
        before = {name: os.stat(self.path(name)).st_mtime_ns for name in self.listing()}
        done = self.batch('in', '-o', 'out', *MM, '--cache', 'cache', '--dry-run', '--format', 'json', code=3)
        estimate = json.loads(done.stdout)
        self.assertEqual(schema.problems(estimate, schema.load(SCHEMAS / 'estimate.schema.json')), [])
        self.assertEqual(estimate['counts'], {'from_the_cache': 1, 'up_to_date': 2, 'failed': 1, 'not_begun': 0, 'to_build': 1})
        self.assertEqual([each['name'] for each in estimate['estimates']], ['new'])
        self.assertEqual({name: os.stat(self.path(name)).st_mtime_ns for name in self.listing()}, before)
        report = self.load('r.json') if self.batch('in', '-o', 'out', *MM, '--cache', 'cache', '--report', 'r.json', '-q', code=3) else None
        self.assertEqual((report['counts']['built'], report['counts']['from_the_cache'], report['counts']['failed']), (1, 1, 1))
        made = sum(output['bytes'] for output in report['outputs'] if '/new.' in output['path'])
        self.assertLess(made / estimate['estimates'][0]['file_bytes'], 3)
        self.assertGreater(made / estimate['estimates'][0]['file_bytes'], 1 / 3)


if __name__ == '__main__':
    command.main()
