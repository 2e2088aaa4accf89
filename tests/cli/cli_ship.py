# SPDX-License-Identifier: GPL-3.0-or-later
"""What a batch has made on its way to another machine: archives that are the same bytes each time, and files that are replaced while somebody reads them."""
import hashlib
import json
import mmap
import os
import pathlib
import shutil
import subprocess
import tarfile
import time
import unittest

import command
import shapes
from cli_scene import SCENE

MM = ('--unit', 'mm', '--voxel', '2mm')


class Ship(command.CommandTest):
    def parts(self):
        for name, radius in (('cup', 20), ('sub/Schüssel', 15), ('sub/' + 95 * 'l', 18), (70 * 'd' + '/' + 70 * 'e' + '/with space', 12)):
            path = pathlib.Path(self.path('in', name + '.stl'))
            path.parent.mkdir(parents=True, exist_ok=True)
            shapes.write_stl(path, shapes.cup(radius=radius, height=30, wall=3, segments=24))

    def batch(self, *arguments, **more):
        return self.run_voxshell('batch', *arguments, **more)

    def digest(self, name):
        return hashlib.sha256(pathlib.Path(self.path(name)).read_bytes()).hexdigest()

    def test_an_archive(self):
        self.parts()
        for run, jobs in enumerate((1, 2, 5)):
            self.batch('in', '-o', f'out{run}', *MM, '-j', jobs, '--cache', f'cache{run}', '--archive', f'{run}/parts.tar', '-q')
            self.batch('in', '-o', f'out{run}', *MM, '-j', jobs, '--cache', f'cache{run}', '--archive', f'{run}/parts.tar.zst', '-q')
        for name in ('parts.tar', 'parts.tar.zst'):
            self.assertEqual(len({self.digest(f'{run}/{name}') for run in range(3)}), 1)
        self.assertLess(os.path.getsize(self.path('0/parts.tar.zst')), os.path.getsize(self.path('0/parts.tar')))
        with tarfile.open(self.path('0/parts.tar')) as tar:
            members = tar.getmembers()
            self.assertEqual([(m.mtime, m.uid, m.gid, m.mode, m.type) for m in members], len(members) * [(0, 0, 0, 0o644, tarfile.REGTYPE)])
            tar.extractall(self.path('lab'), **({'filter': 'data'} if hasattr(tarfile, 'data_filter') else {}))
        made = {name: digest for name, digest in self.digests(self.path('out0')).items() if not name.startswith('.voxshell')}
        self.assertEqual(self.digests(self.path('lab', 'parts')), made)
        self.run_voxshell('verify', '--manifest', 'lab/parts', out='^ok lab/parts/manifest.json 12 files')
        if shutil.which('tar') and shutil.which('zstd'):  # and as people do it
            os.mkdir(self.path('other'))
            subprocess.run(['tar', 'xf', self.path('0/parts.tar.zst'), '-C', self.path('other')], check=True)
            self.assertEqual(self.digests(self.path('other', 'parts')), made)

    def test_an_archive_of_what_is_not_there(self):
        self.parts()
        self.batch('in', '-o', 'out', *MM, '-q')
        manifest = json.loads(pathlib.Path(self.path('out', 'manifest.json')).read_text(encoding='utf-8'))
        manifest['files'].append({'path': 'lost.vdb', 'bytes': 3, 'sha256': 64 * '0'})
        pathlib.Path(self.path('out', 'manifest.json')).write_text(json.dumps(manifest), encoding='utf-8')
        self.batch('in', '-o', 'out', *MM, '--archive', 'a.tar', '-q')  # is not in the manifest any more
        stays = pathlib.Path(self.path('out', 'old.vdb'))
        stays.write_bytes(b'abc')
        manifest['files'][-1]['path'] = 'old.vdb'
        pathlib.Path(self.path('out', 'manifest.json')).write_text(json.dumps(manifest), encoding='utf-8')
        self.batch('in', '-o', 'out', *MM, '--archive', 'b.tar', code=3, err='out/old.vdb: is not the file that the manifest means')
        self.assertFalse(os.path.exists(self.path('b.tar')))
        for name, code, fact in (('a.zip', 1, 'is called NAME.tar.zst'), ('.tar', 1, 'is called NAME'), ('a.tar', 2, 'exists with other content')):
            os.path.exists(self.path('extra.stl')) or shapes.write_stl(self.path('extra.stl'), shapes.box())
            self.batch('extra.stl', '-o', 'out2', *MM, '--archive', name, code=code, err=fact)

    def test_files_are_replaced_never_changed(self):
        """Who has a file open keeps what it had, to the last byte: a new one takes its name."""
        self.parts()
        arguments = ('in', '-o', 'out', *MM, '--cache', 'cache', '--archive', 'parts.tar.zst', '--report', 'report.json', '--depfile', 'out.d', '--force', '-q')
        self.batch(*arguments)
        files = [p for p in (*pathlib.Path(self.path('out')).rglob('*'), self.folder / 'parts.tar.zst', self.folder / 'report.json') if p.is_file()]
        held = []
        for path in files:
            with open(path, 'rb') as file:
                held.append((path, path.read_bytes(), mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ), os.fstat(file.fileno()).st_ino))
        for path in pathlib.Path(self.path('in')).rglob('*.stl'):
            shapes.write_stl(path, shapes.cup(radius=9, height=21, wall=3, segments=24))
        self.batch(*arguments)
        self.run_voxshell('convert', 'in/cup.stl', '-o', 'out', '--unit', 'mm', '--voxel', '3mm', '--force', '-q')
        for path, before, view, inode in held:
            self.assertEqual(view[:], before, path)
            self.assertNotEqual(path.read_bytes(), before, path)
            self.assertNotEqual(path.stat().st_ino, inode, path)

    def test_an_asset_replaced_under_a_running_loop(self):
        shapes.write_glb(self.path('cup.glb'), shapes.cup(radius=40, height=80, wall=6))
        shapes.write_glb(self.path('sphere.glb'), shapes.sphere(radius=8))
        pathlib.Path(self.path('press.scene.json')).write_text(json.dumps(SCENE), encoding='utf-8')
        self.run_voxshell('convert', 'press.scene.json', '-o', 'out', '-q')
        run = ('simulate', 'out/press.plan', '--seconds', '4', '-q')
        self.run_voxshell(*run, '--trace', 'alone.csv')
        process = subprocess.Popen([command.BIN, *run, '--realtime', '--trace', 'other.csv'], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(0.5)  # the loop has its assets, and runs
        replaced = 0
        while process.poll() is None:
            size = 40 + replaced % 2 * 10
            shapes.write_glb(self.path('cup.glb'), shapes.cup(radius=size, height=2 * size, wall=6))
            self.run_voxshell('convert', 'press.scene.json', '-o', 'out', '--force', '-q')
            replaced += process.poll() is None
        self.assertGreater(replaced, 0)
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, out + err)
        rows = [pathlib.Path(self.path(f'{name}.csv')).read_text(encoding='utf-8').splitlines() for name in ('alone', 'other')]
        self.assertEqual(len(rows[0]), len(rows[1]))
        self.run_voxshell(*run)  # and the next one takes the new file

    def test_an_asset_cut_under_a_running_loop(self):
        shapes.write_glb(self.path('cup.glb'), shapes.cup(radius=40, height=80, wall=6))
        shapes.write_glb(self.path('sphere.glb'), shapes.sphere(radius=8))
        pathlib.Path(self.path('press.scene.json')).write_text(json.dumps(SCENE), encoding='utf-8')
        self.run_voxshell('convert', 'press.scene.json', '-o', 'out', '-q')
        process = subprocess.Popen([command.BIN, 'simulate', 'out/press.plan', '--seconds', '3', '-q', '--realtime'], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(1)
        for name in ('press.voxmap', 'press.pointshell'):
            os.truncate(self.path('out', name), 0)
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, out + err)
        self.run_voxshell('simulate', 'out/press.plan', '--seconds', '1', code=3, err='press.voxmap')


if __name__ == '__main__':
    command.main()
