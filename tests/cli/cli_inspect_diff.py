# SPDX-License-Identifier: GPL-3.0-or-later
"""inspect and diff on assets that convert made, and on what are none."""
import json
import os
import pathlib

import command
import schema
import shapes

INSPECT = schema.load(command.SOURCE / 'formats/schema/inspect.schema.json')
DIFF = schema.load(command.SOURCE / 'formats/schema/diff.schema.json')


class InspectAndDiff(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.convert('a', shapes.box(10, 10, 10, at=(0.5, 0.5, 0.5)))

    def convert(self, folder, triangles, *more):
        shapes.write_stl(self.path('part.stl'), triangles)
        self.run_voxshell('convert', 'part.stl', '-o', folder, '--unit', 'mm', '--voxel', '1mm', '-q', *more)

    def inspect(self, name):
        return json.loads(self.run_voxshell('inspect', name, '--format', 'json', err='').stdout)

    def test_inspect_json(self):
        for kind in ('voxmap', 'pointshell', 'vdb'):
            told = self.inspect(f'a/part.{kind}')
            self.assertEqual(schema.problems(told, INSPECT), [])
            self.assertEqual((told['kind'], told['voxel_m'], told['bytes']),
                             (kind, 0.001, pathlib.Path(self.path('a', f'part.{kind}')).stat().st_size))
            self.assertEqual(told['source_sha256'], command.hashlib.sha256(pathlib.Path(self.path('part.stl')).read_bytes()).hexdigest())
        told = self.inspect('a/part.voxmap')
        # A box from 0.5 to 10.5 mm: cells 0..10, the outer layer surface.
        self.assertEqual(told['bbox_cells'], {'min': [0, 0, 0], 'max': [10, 10, 10]})
        self.assertEqual((told['surface_cells'], told['interior_cells']), (11 ** 3 - 9 ** 3, 9 ** 3))
        self.assertEqual({**self.inspect('a/part.vdb'), **dict.fromkeys(('kind', 'format', 'bytes', 'content_hash'))},
                         {**told, **dict.fromkeys(('kind', 'format', 'bytes', 'content_hash'))})
        shell = self.inspect('a/part.pointshell')
        self.assertEqual((shell['points'], shell['kind_of_shell']), (602, 'exact'))
        self.assertAlmostEqual(shell['area_m2'], 600e-6, delta=1e-10)

    def test_inspect_first_line(self):
        self.run_voxshell('inspect', 'a/part.voxmap', err='', out=r'^part\.voxmap: voxmap 1\.0, 11 x 11 x 11 mm, voxel 1 mm, 602 surface '
                          r'and 729 interior cells, [\d.]+ KiB, source [0-9a-f]{12}\n')
        self.run_voxshell('inspect', 'a/part.pointshell', err='', out=r'^part\.pointshell: pointshell 1\.0, 10 x 10 x 10 mm, voxel 1 mm, '
                          r'602 exact points, [\d.]+ KiB, source [0-9a-f]{12}\n')

    def test_inspect_refuses(self):
        self.refused(2, 'none: No such file', 'none', verb='inspect')
        self.refused(2, 'a: is a folder', 'a', verb='inspect')
        self.refused(5, r'part\.stl: is not a \.voxmap', 'part.stl', verb='inspect')
        self.refused(1, 'FILE', verb='inspect')
        whole = pathlib.Path(self.path('a', 'part.voxmap')).read_bytes()
        for name, data in (('short.voxmap', whole[:-64]), ('empty.voxmap', b''), ('text.pointshell', b'hello'),
                           ('flipped.voxmap', whole[:700] + bytes([whole[700] ^ 1]) + whole[701:])):
            self.folder.joinpath(name).write_bytes(data)
            self.refused(3, name, name, verb='inspect')
        shell = pathlib.Path(self.path('a', 'part.pointshell')).read_bytes()
        self.folder.joinpath('cut.pointshell').write_bytes(shell[:len(shell) // 2])
        self.refused(3, 'cut', 'cut.pointshell', verb='inspect')

    def test_equal(self):
        for kind in ('voxmap', 'pointshell', 'vdb'):
            self.run_voxshell('diff', f'a/part.{kind}', f'a/part.{kind}', out='^0 (cells|points) changed\nequal\n$', err='')
        self.run_voxshell('diff', 'a/part.voxmap', 'a/part.vdb', out='equal\n$')
        self.run_voxshell('diff', 'a/part.voxmap', 'a/part.vdb', '-q', out='', err='')

    def test_cells_that_changed(self):
        self.convert('b', shapes.box(10, 10, 11, at=(0.5, 0.5, 0.5)))
        # 121 cells of the new layer; of the old end layer, the 9 x 9 in the middle become interior.
        done = self.run_voxshell('diff', 'a/part.voxmap', 'b/part.voxmap', code=6, out=r'^202 cells changed, the largest change 1 mm\n')
        self.assertEqual(len([line for line in done.stdout.splitlines() if line.startswith('  (')]), 10)
        self.assertRegex(done.stdout, r'\n  \([-\d.e]+, [-\d.e]+, [-\d.e]+\) m  cell \(0, 0, 11\): free -> surface\n')
        self.assertRegex(done.stdout, 'and 192 more\n')
        told = json.loads(self.run_voxshell('diff', 'a/part.voxmap', 'b/part.vdb', '--format', 'json', code=6).stdout)
        self.assertEqual(schema.problems(told, DIFF), [])
        self.assertEqual((told['values']['changed'], told['values']['largest_m']), (202, 0.001))
        self.run_voxshell('diff', 'a/part.voxmap', 'b/part.voxmap', '--tolerance', '1mm', out='^0 cells changed by more than 1 mm\n')
        self.run_voxshell('diff', 'a/part.voxmap', 'b/part.voxmap', '--tolerance', '0.9mm', code=6)

    def test_points_that_changed(self):
        self.convert('b', shapes.box(10.125, 10, 10, at=(0.5, 0.5, 0.5)))
        self.run_voxshell('diff', 'a/part.pointshell', 'b/part.pointshell', code=6, out=r'points changed, the largest change 0\.125 mm\n.*normal turned .* degrees, area 7.5e-07 -> 8.75e-07 m2')
        told = json.loads(self.run_voxshell('diff', 'a/part.pointshell', 'b/part.pointshell', '--format', 'json', code=6).stdout)
        self.assertEqual(schema.problems(told, DIFF), [])
        self.run_voxshell('diff', 'a/part.pointshell', 'b/part.pointshell', '--tolerance', '0.126mm', out='equal\n$')
        self.run_voxshell('diff', 'a/part.pointshell', 'b/part.pointshell', '--tolerance', '0.12mm', code=6)

    def test_structure(self):
        self.run_voxshell('convert', 'part.stl', '-o', 'b', '--unit', 'mm', '--voxel', '2mm', '-q', '--shell', 'naive')
        self.run_voxshell('diff', 'a/part.voxmap', 'b/part.voxmap', code=6, out='^voxel: 0.001 m / 0.002 m\n.*differs\n$')
        self.run_voxshell('diff', 'a/part.pointshell', 'b/part.pointshell', code=6, out='kind of shell: exact / naive')
        self.refused(1, 'cannot be compared', 'a/part.voxmap', 'a/part.pointshell', verb='diff')
        self.refused(1, '--tolerance', 'a/part.voxmap', 'a/part.voxmap', '--tolerance', '1', verb='diff')
        self.refused(1, 'more than 16 voxels', 'a/part.voxmap', 'a/part.voxmap', '--tolerance', '1m', verb='diff')
        self.refused(2, 'none', 'a/part.voxmap', 'none', verb='diff')

    def test_folders(self):
        self.run_voxshell('batch', 'part.stl', '-o', 'one', '--unit', 'mm', '--voxel', '1mm', '-q')
        self.run_voxshell('batch', 'part.stl', '-o', 'two', '--unit', 'mm', '--voxel', '1mm', '-q')
        self.run_voxshell('diff', 'one', 'two', out='^3 equal, 0 differ, 0 only in one, 0 only in two\n$')
        self.run_voxshell('convert', 'part.stl', '-o', 'coarse', '--unit', 'mm', '--voxel', '2mm', '-q')
        os.replace(self.path('coarse', 'part.voxmap'), self.path('two', 'part.voxmap'))
        os.replace(self.path('two', 'part.vdb'), self.path('two', 'other.vdb'))
        done = self.run_voxshell('diff', 'one', 'two', code=6)
        for line in ('other.vdb: only in b\n', 'part.vdb: only in a\n', 'part.voxmap\nvoxel: 0.001 m / 0.002 m\n', '\n1 equal, 1 differ, 1 only in one, 1 only in two\n'):
            self.assertIn(line, done.stdout)
        told = json.loads(self.run_voxshell('diff', 'one', 'two', '--format', 'json', code=6).stdout)
        self.assertEqual(schema.problems(told, schema.load(command.SOURCE / 'formats/schema/diff_folders.schema.json')), [])
        self.assertEqual([file['state'] for file in told['files']], ['only in b', 'equal', 'only in a', 'differs'])
        with open(self.path('two', 'part.pointshell'), 'r+b') as file:
            file.truncate(1000)
        self.run_voxshell('diff', 'one', 'two', code=3, err='two/part.pointshell: ')
        self.refused(1, 'a folder and a file', 'one', 'a/part.voxmap', verb='diff')
        os.makedirs(self.path('empty'))
        self.refused(3, 'empty: holds no', 'one', 'empty', verb='diff')

    def test_solid_against_hollow(self):
        """Solid runs are compared without their bricks being there."""
        self.convert('solid', shapes.box(100, 100, 100))
        self.convert('hollow', shapes.box(100, 100, 100) + shapes.flipped(shapes.box(60, 60, 60, at=(20, 20, 20))))
        done = json.loads(self.run_voxshell('diff', 'solid/part.voxmap', 'hollow/part.voxmap', '--format', 'json', code=6).stdout)
        one, two = self.inspect('solid/part.voxmap'), self.inspect('hollow/part.voxmap')
        self.assertEqual(done['values']['changed'], one['interior_cells'] - two['interior_cells'])


if __name__ == '__main__':
    command.main()
