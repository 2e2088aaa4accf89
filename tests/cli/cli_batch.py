# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell batch: each distinct part once, nothing twice, nothing half; what it ships is checked."""
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time

import command
import schema
import shapes

SCHEMAS = pathlib.Path(__file__).parents[2] / 'formats' / 'schema'


class Batch(command.CommandTest):
    def stl(self, *name, radius=20, segments=24):
        path = pathlib.Path(self.path(*name))
        path.parent.mkdir(parents=True, exist_ok=True)
        shapes.write_stl(str(path), shapes.cup(radius=radius, height=2 * radius, wall=3, segments=segments))
        return str(path)

    def folder_of_parts(self):
        self.stl('in', 'cup.stl')
        self.stl('in', 'sub', 'same cup.stl')
        self.stl('in', 'sub', 'Schüssel.stl', radius=15)
        self.stl('in', '.hidden', 'no.stl')

    def batch(self, *arguments, **more):
        return self.run_voxshell('batch', *arguments, **more)

    def report(self, *arguments, **more):
        done = self.batch(*arguments, '--format', 'json', **more)
        report = json.loads(done.stdout)
        self.assertEqual(schema.problems(report, schema.load(SCHEMAS / 'report.schema.json')), [])
        return report

    def results(self, folder):
        return {name: digest for name, digest in self.digests(folder).items() if not name.startswith('.voxshell-cache')}

    def test_each_once_then_nothing(self):
        self.folder_of_parts()
        arguments = ('in', '-o', 'out', '--unit', 'mm', '--voxel', '2mm')
        first = self.report(*arguments)
        self.assertEqual(first['counts'], {'built': 2, 'from_the_cache': 1, 'up_to_date': 0, 'failed': 0, 'not_begun': 0})
        self.assertEqual([part['name'] for part in first['parts']], ['cup', 'sub/Schüssel', 'sub/same cup'])
        one = self.digests(self.path('out'))
        for ending in ('vdb', 'voxmap', 'pointshell'):
            self.assertEqual(one[f'cup.{ending}'], one[f'sub/same cup.{ending}'])
        before = self.results(self.path('out'))
        second = self.batch(*arguments)
        self.assertEqual(second.stdout, '0 built, 3 up to date, 0 failed\n')
        self.assertEqual(self.results(self.path('out')), before)
        # The bytes that convert makes, and the report's hashes are theirs.
        self.run_voxshell('convert', 'in/cup.stl', '-o', 'alone', '--unit', 'mm', '--voxel', '2mm', '-q')
        for name, digest in self.digests(self.path('alone')).items():
            self.assertEqual(before[name], digest)
        for output in first['outputs']:
            self.assertEqual(before[os.path.relpath(output['path'], 'out')], output['sha256'])

    def test_one_changed_part_is_built_and_replaces_its_own(self):
        self.folder_of_parts()
        arguments = ('in', '-o', 'out', '--unit', 'mm', '--voxel', '2mm')
        self.batch(*arguments)
        self.stl('in', 'cup.stl', radius=18)
        self.batch(*arguments, out='^1 built, 2 up to date, 0 failed\n$')
        # A file that something else has changed is not lost.
        with open(self.path('out', 'cup.voxmap'), 'r+b') as file:
            data = file.read()
            file.seek(0)
            os.unlink(file.name)
        with open(self.path('out', 'cup.voxmap'), 'wb') as file:
            file.write(data[:100])
        done = self.batch(*arguments, code=2, err='cup.voxmap: exists with other content; --force overwrites')
        self.assertEqual(os.path.getsize(self.path('out', 'cup.voxmap')), 100)
        self.assertEqual(done.stdout, '0 built, 2 up to date, 1 failed\n')
        self.batch(*arguments, '--force')
        self.run_voxshell('verify', 'out', '-q')

    def test_a_damaged_cache_is_made_again(self):
        self.stl('in', 'cup.stl')
        arguments = ('in', '-o', 'out', '--unit', 'mm', '--voxel', '2mm', '--cache', 'cache')
        self.batch(*arguments)
        whole = self.results(self.path('out'))
        stored = next(pathlib.Path(self.path('cache')).rglob('voxmap'))
        stored.write_bytes(b'\0' + stored.read_bytes()[1:])  # the result is the same file: both are damaged
        self.batch(*arguments, code=2, err='exists with other content')
        self.batch(*arguments, '--force')
        self.assertEqual(self.results(self.path('out')), whole)

    def test_a_cache_shared_by_folders(self):
        self.folder_of_parts()
        options = ('--unit', 'mm', '--cache', 'cache')
        self.batch('in', '-o', 'one', '--voxel', '2mm', *options)
        self.batch('in', '-o', 'two', '--voxel', '2mm', *options, out='^0 built, 3 from the cache, 0 failed\n$')
        self.assertEqual(self.results(self.path('one')), self.results(self.path('two')))
        for other in (('--voxel', '2.5mm'), ('--voxel', '2mm', '--shell', 'naive'), ('--voxel', '2mm', '--up', 'z')):
            self.batch('in', '-o', 'other', *other, *options, '--force', out='^2 built, 1 from the cache')
        self.batch('in', '-o', 'three', '--voxel', '2mm', *options, '--cache-size', '1K', out='3 from the cache')
        self.assertEqual(list(pathlib.Path(self.path('cache')).rglob('entry.json')), [])
        self.assertEqual(self.results(self.path('one')), self.results(self.path('three')))

    def test_a_bad_part_does_not_stop_the_rest(self):
        self.folder_of_parts()
        with open(self.path('in', 'bad.stl'), 'wb') as file:
            file.write(b'solid x\nfacet')
        arguments = ('in', '-o', 'out', '--unit', 'mm', '--voxel', '2mm', '-j1')
        report = self.report(*arguments, code=3, err='^voxshell batch: error: in/bad.stl: .*\n$')
        self.assertEqual(report['counts']['failed'], 1)
        self.assertEqual([part['path'] for part in report['failed']], ['bad'])
        self.assertEqual(len(report['parts']), 3)
        self.run_voxshell('verify', 'out', '-q')
        os.truncate(self.path('in', 'sub', 'Schüssel.stl'), 90)  # the smaller of the two that fail comes last
        shutil.rmtree(self.path('out'))
        report = self.report(*arguments, '--fail-fast', code=3)
        self.assertEqual(report['counts']['failed'] + report['counts']['not_begun'] + report['counts']['built'] + report['counts']['from_the_cache'], 4)
        self.assertGreaterEqual(report['counts']['failed'], 1)

    def test_the_same_with_any_number_of_threads(self):
        self.folder_of_parts()
        for jobs in ('1', '2', '5'):
            self.batch('in', '-o', f'out{jobs}', '--unit', 'mm', '--voxel', '1.5mm', '-j', jobs, '--report', f'{jobs}.json', '--reproducible', '-q')
        one = self.results(self.path('out1'))
        self.assertEqual(one, self.results(self.path('out2')))
        self.assertEqual(one, self.results(self.path('out5')))
        reports = [pathlib.Path(self.path(f'{jobs}.json')).read_text(encoding='utf-8') for jobs in ('1', '2', '5')]
        self.assertEqual(reports[0], reports[1])
        self.assertEqual(reports[0], reports[2])

    def test_an_assembly_per_part(self):
        mesh = shapes.cup(radius=20, height=30, wall=4, segments=24)
        other = shapes.cup(radius=10, height=30, wall=4, segments=24)
        half = 0.5 ** 0.5
        shapes.write_assembly(self.path('robot.glb'), [('cup', mesh), ('cup', other), ('copy of cup', mesh)], [
            {'name': 'base', 'mesh': 0},
            {'name': 'turned', 'mesh': 0, 'rotation': [half, 0, 0, half], 'translation': [0.1, 0, 0]},
            {'name': 'again', 'mesh': 2, 'translation': [0, 0.3, 0]},
            {'name': 'small', 'mesh': 1},
            {'name': 'double', 'mesh': 0, 'scale': [2, 2, 2]},
            {'name': 'mirrored', 'mesh': 1, 'scale': [-1, 1, 1]},
            {'name': 'double too', 'mesh': 2, 'scale': [2, 2, 2], 'rotation': [0, half, 0, half]}])
        report = self.report('robot.glb', '-o', 'out', '--per-part', '--voxel', '2mm')
        self.assertEqual(report['counts']['built'], 4)
        assembly = json.loads(pathlib.Path(self.path('out', 'robot', 'assembly.json')).read_text(encoding='utf-8'))
        self.assertEqual(schema.problems(assembly, schema.load(SCHEMAS / 'assembly.schema.json')), [])
        self.assertEqual([part['name'] for part in assembly['parts']], ['cup', 'cup-2', 'cup-3', 'cup-4'])
        self.assertEqual([part['instances'] for part in assembly['parts']], [3, 1, 2, 1])
        self.assertEqual([each['part'] for each in assembly['instances']], [0, 0, 0, 1, 2, 3, 2])
        turned = assembly['instances'][1]
        self.assertEqual(turned['name'], '/turned')
        self.assertEqual(turned['position_m'][1:], [0, 0])
        for got, wanted in zip(turned['orientation_wxyz'], [half, half, 0, 0]):
            self.assertAlmostEqual(got, wanted, 6)
        self.assertLess(assembly['pose_error_m'], 1e-7)
        digests = self.digests(self.path('out', 'robot'))
        for part in assembly['parts']:
            for file in part['files'].values():
                self.assertEqual(digests[file['path']], file['sha256'])
        self.batch('robot.glb', '-o', 'out', '--per-part', '--voxel', '2mm', out='^0 built, 4 up to date, 0 failed\n$')

    def test_the_tree_and_the_materials_of_an_assembly(self):
        mesh = shapes.cup(radius=20, height=30, wall=4, segments=24)
        half = 0.5 ** 0.5
        for ending in ('glb', 'gltf'):
            shapes.write_assembly(self.path(f'arm.{ending}'), [('cup', mesh, 1), ('cup', mesh, 0), ('pad', shapes.box())], [
                {'name': 'base', 'children': [1, 2], 'translation': [0, 0, 1]},
                {'name': 'joint', 'children': [3], 'rotation': [half, 0, 0, half]},
                {'mesh': 1, 'name': 'base'},
                {'mesh': 0, 'name': 'Flansch "ä"', 'scale': [2, 2, 2]},
                {'mesh': 2, 'name': 'lost'},
                {'name': 'empty'}], roots=[5, 0], materials=['steel', ''])
            self.batch(f'arm.{ending}', '-o', ending, '--per-part', '--voxel', '3mm', out='^2 built, 0 failed\n$')
            assembly = json.loads(pathlib.Path(self.path(ending, 'arm', 'assembly.json')).read_text(encoding='utf-8'))
            self.assertEqual(schema.problems(assembly, schema.load(SCHEMAS / 'assembly.schema.json')), [])
            self.assertEqual(assembly['materials'], [{'name': 'steel'}, {'name': ''}])
            self.assertEqual([(node['name'], node['parent']) for node in assembly['nodes']],
                             [('empty', None), ('base', None), ('joint', 1), ('Flansch "ä"', 2), ('base', 1)])
            self.assertEqual([(each['name'], each['node'], each['materials']) for each in assembly['instances']],
                             [('/base/joint/Flansch "ä"', 3, [1]), ('/base/base', 4, [0])])
            # Poses along the tree are the instance's: assembly from part is what the nodes above say, less the part's own shape.
            pose = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]
            at = assembly['instances'][0]['node']
            while at is not None:
                node = assembly['nodes'][at]
                pose = [sum(node['pose'][4 * r + n] * pose[4 * n + c] for n in range(3)) + (node['pose'][4 * r + 3] if c == 3 else 0)
                        for r in range(3) for c in range(4)]
                at = node['parent']
            self.assertEqual(assembly['parts'][0]['shape'], [2, 0, 0, 0, 2, 0, 0, 0, 2])
            for got, wanted in zip(pose, [2, 0, 0, 0, 0, 0, -2, 0, 0, 2, 0, 1]):
                self.assertAlmostEqual(got, wanted, 6)
            for got, wanted in zip(assembly['instances'][0]['orientation_wxyz'], [half, half, 0, 0]):
                self.assertAlmostEqual(got, wanted, 6)
        self.batch('arm.glb', '-o', 'up', '--per-part', '--voxel', '3mm', '--up', 'z', '-q')
        turned = json.loads(pathlib.Path(self.path('up', 'arm', 'assembly.json')).read_text(encoding='utf-8'))
        self.assertEqual(turned['nodes'][1]['pose'], [1, 0, 0, 0, 0, 0, 1, 1, 0, -1, 0, 0])
        self.assertEqual(turned['nodes'][2], assembly['nodes'][2])

    def test_the_solids_of_an_stl(self):
        with open(self.path('two.stl'), 'w', encoding='ascii') as file:
            for name, shape in (('left jaw', shapes.box(10, 10, 10)), ('empty', []), ('right jaw', shapes.box(10, 10, 10, at=(30, 0, 0)))):
                file.write(f'solid {name}\n')
                for t in shape:
                    corners = ''.join('vertex %g %g %g\n' % p for p in t)
                    file.write(f'facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n')
                file.write(f'endsolid {name}\n')
        self.batch('two.stl', '-o', 'out', '--per-part', '--unit', 'mm', '--voxel', '1mm', out='^2 built, 0 failed\n$')
        assembly = json.loads(pathlib.Path(self.path('out', 'two', 'assembly.json')).read_text(encoding='utf-8'))
        self.assertEqual([part['name'] for part in assembly['parts']], ['left jaw', 'right jaw'])
        self.run_voxshell('verify', 'out', '-q')

    def test_endings_of_any_case(self):
        shapes.write_glb(self.path('Ball.Glb'), shapes.sphere(radius=15))
        self.stl('Cup.sTL')
        self.batch('Ball.Glb', '-o', 'out', '--voxel', '2mm', out='^1 built, 0 failed\n$')  # metres: no unit asked for
        self.refused(1, 'has no unit', 'Cup.sTL', '-o', 'out2', '--voxel', '2mm', verb='batch')
        self.batch('Ball.Glb', 'Cup.sTL', '-o', 'out', '--voxel', '2mm', '--unit', 'mm', out='^1 built, 1 up to date, 0 failed\n$')

    def test_shipped_and_checked(self):
        self.folder_of_parts()
        self.batch('in', '-o', 'out', '--unit', 'mm', '--voxel', '2mm', '--cache', 'cache', '-q')
        manifest = json.loads(pathlib.Path(self.path('out', 'manifest.json')).read_text(encoding='utf-8'))
        self.assertEqual(schema.problems(manifest, schema.load(SCHEMAS / 'manifest.schema.json')), [])
        shutil.copytree(self.path('out'), self.path('lab'))
        self.run_voxshell('verify', '--manifest', 'lab', out='^ok lab/manifest.json 9 files')
        with open(self.path('lab', 'cup.vdb'), 'r+b') as file:
            file.seek(500)
            file.write(b'?')
        os.truncate(self.path('lab', 'sub', 'same cup.voxmap'), 77)
        os.unlink(self.path('lab', 'sub', 'Schüssel.pointshell'))
        done = self.run_voxshell('verify', '--manifest', 'lab/manifest.json', code=3, out='')
        self.assertEqual(len(done.stderr.splitlines()), 3)
        for fact in ('cup.vdb: has other content', 'Schüssel.pointshell: is not there', 'same cup.voxmap: has 77 bytes'):
            self.assertIn(fact, done.stderr)
        for text in ('{', '{"schema": "voxshell-manifest/1", "files": [{"path": "../x", "bytes": 1, "sha256": ""}]}', '[]'):
            pathlib.Path(self.path('lab', 'manifest.json')).write_text(text, encoding='utf-8')
            self.refused(3, 'manifest', 'lab', '--manifest', verb='verify')

    def test_killed_at_any_moment_then_completed(self):
        """VXS_KILLS=200: as often, by hand."""
        for n in range(12):
            self.stl('in', f'{n}.stl', radius=12 + n)
        arguments = [command.BIN, 'batch', 'in', '-o', 'out', '--unit', 'mm', '--voxel', '1mm', '-q']
        begin = time.monotonic()
        subprocess.run([*arguments[:4], 'whole', *arguments[5:]], cwd=self.folder, check=True, timeout=120)
        spent = time.monotonic() - begin
        whole = self.results(self.path('whole'))
        dice = random.Random(7)
        for kill in range(int(os.environ.get('VXS_KILLS', '12'))):
            kind = signal.SIGKILL if kill % 3 else signal.SIGINT
            process = subprocess.Popen(arguments, cwd=self.folder, stderr=subprocess.DEVNULL)
            time.sleep(dice.uniform(0, spent))
            process.send_signal(kind)
            process.wait(timeout=60)
            there = self.results(self.path('out')) if os.path.exists(self.path('out')) else {}
            for name, digest in there.items():
                if not os.path.basename(name).startswith('.') and name != 'manifest.json':
                    self.assertEqual(digest, whole[name], name)
            if kill % 4 == 3:
                subprocess.run(arguments, cwd=self.folder, check=True, timeout=120)
                made = {name: digest for name, digest in self.results(self.path('out')).items() if not os.path.basename(name).startswith('.')}
                self.assertEqual(made, whole)
                shutil.rmtree(self.path('out'))

    def test_a_list(self):
        self.folder_of_parts()
        with open(self.path('in', 'list.txt'), 'w', encoding='utf-8') as file:
            file.write('# two of them\ncup.stl\r\n\nsub/Schüssel.stl\n')
        self.batch('--filelist', 'in/list.txt', '-o', 'out', '--unit', 'mm', '--voxel', '2mm', out='^2 built, 0 failed\n$')

    def test_refused(self):
        self.stl('a', 'cup.stl')
        self.stl('b', 'cup.stl')
        os.makedirs(self.path('empty'))
        mm = ('--unit', 'mm', '--voxel', '2mm')
        for code, fact, arguments in (
                (1, 'nothing to convert', ('-o', 'out', *mm)),
                (1, 'empty: no .stl', ('empty', '-o', 'out', *mm)),
                (1, 'is neither a folder', ('missing', '-o', 'out', *mm)),
                (1, 'would both write cup', ('a', 'b', '-o', 'out', *mm)),
                (1, 'has no unit', ('a', '-o', 'out', '--voxel', '2mm')),
                (1, '--voxel is required', ('a', '-o', 'out', '--unit', 'mm')),
                (2, 'list.txt: cannot read', ('--filelist', 'list.txt', '-o', 'out', *mm))):
            self.refused(code, fact, *arguments, verb='batch')

    def test_no_room_and_no_permission(self):
        if os.geteuid() == 0 and subprocess.run(['mount', '-t', 'tmpfs', '-o', 'size=300k', 'none', self.path('')], capture_output=True, check=False).returncode == 0:
            try:
                self.stl('in', 'cup.stl', radius=40, segments=100)
                done = self.batch('in', '-o', 'out', '--unit', 'mm', '--voxel', '0.5mm', code=2)
                self.assertRegex(done.stderr, '^voxshell batch: error: .*No space left on device\n$')
                self.assertEqual([p for p in pathlib.Path(self.path('out')).rglob('*.voxmap')], [])
            finally:
                subprocess.run(['umount', '-l', self.path('')], check=True)
        self.stl('in', 'cup.stl')
        self.refused(2, 'in/cup.stl', 'in/cup.stl', '-o', 'in/cup.stl', '--unit', 'mm', '--voxel', '2mm', verb='batch')


if __name__ == '__main__':
    command.main()
