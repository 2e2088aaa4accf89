# SPDX-License-Identifier: GPL-3.0-or-later
"""verify: passes what convert made, refuses everything else, and tells a mesh from another."""
import json
import random
import time

import command
import schema
import shapes

VERIFY = schema.load(command.SOURCE / 'formats/schema/verify.schema.json')


class Verify(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.make('cup', shapes.cup(), '0.7mm')

    def make(self, name, triangles, voxel, folder='out'):
        shapes.write_stl(self.path(name + '.stl'), triangles)
        self.run_voxshell('convert', name + '.stl', '-o', folder, '--unit', 'mm', '--voxel', voxel, '-q')

    def against(self, asset, mesh, code, **more):
        done = self.run_voxshell('verify', asset, '--against', mesh, '--unit', 'mm', '--format', 'json', code=code, **more)
        told = json.loads(done.stdout)
        self.assertEqual(schema.problems(told, VERIFY), [])
        entry, = told['files']
        return entry, {m['what']: m for m in entry['against']['measures']}

    def test_passes_what_convert_made(self):
        done = self.run_voxshell('verify', 'out', err='')
        lines = done.stdout.splitlines()
        self.assertEqual([line.split()[:3] for line in lines], [['ok', f'out/cup.{kind}', kind] for kind in ('pointshell', 'vdb', 'voxmap')])
        told = json.loads(self.run_voxshell('verify', 'out', '--format', 'json', err='').stdout)
        self.assertTrue(told['ok'])
        self.assertEqual([f['ok'] for f in told['files']], [True] * 3)

    def test_nothing_to_verify(self):
        self.folder.joinpath('empty').mkdir()
        self.refused(3, r'empty: holds no \.vdb', 'empty', verb='verify')
        self.refused(2, 'none.voxmap', 'none.voxmap', verb='verify')
        self.refused(2, 'none.vdb', 'none.vdb', verb='verify')
        self.refused(1, 'FILE', verb='verify')
        self.refused(1, '--against', 'out/cup.vdb', '--unit', 'mm', verb='verify')
        self.refused(5, r'cup\.stl: ', 'cup.stl', verb='verify')

    @staticmethod
    def expected_code(kind, data):
        """A version or a required feature that is not ours is unsupported, all else invalid."""
        newer = kind != 'vdb' and len(data) >= 128 and (data[8:10] != b'\1\0' or data[24:28] != bytes(4))
        return 5 if newer else 3

    def test_damage(self):
        """Cut or flipped anywhere: invalid, said in one line, quickly. No file of ours survives a flipped bit."""
        pick = random.Random(3)
        for kind in ('voxmap', 'pointshell', 'vdb'):
            whole = self.folder.joinpath(f'out/cup.{kind}').read_bytes()
            damaged = [whole[:size] for size in (1, 8, 40, 127, 300, len(whole) // 2, len(whole) - 1)]
            for _ in range(10):
                at = pick.choice((pick.randrange(8, 1000), pick.randrange(8, len(whole))))
                damaged.append(whole[:at] + bytes([whole[at] ^ 1 << pick.randrange(8)]) + whole[at + 1:])
            for n, data in enumerate(damaged):
                with self.subTest(kind=kind, n=n):
                    self.folder.joinpath(f'bad.{kind}').write_bytes(data)
                    start = time.monotonic()
                    self.refused(self.expected_code(kind, data), rf'bad\.{kind}: ', f'bad.{kind}', verb='verify')
                    self.assertLess(time.monotonic() - start, 60)

    def test_one_bad_file_does_not_hide_the_others(self):
        bad = self.folder.joinpath('out/cup.voxmap')
        data = bytearray(bad.read_bytes())
        data[-100] ^= 4
        bad.write_bytes(data)
        done = self.run_voxshell('verify', 'out', code=3, err=r'cup\.voxmap: rule C\d')
        self.assertEqual(len(done.stdout.splitlines()), 2)
        told = json.loads(self.run_voxshell('verify', 'out', '--format', 'json', code=3).stdout)
        self.assertEqual(schema.problems(told, VERIFY), [])
        self.assertEqual((told['ok'], sorted(f['ok'] for f in told['files'])), (False, [False, True, True]))

    def test_twins_that_are_none(self):
        self.make('ball', shapes.sphere(), '0.7mm', 'other')
        self.folder.joinpath('out/cup.vdb').write_bytes(self.folder.joinpath('other/ball.vdb').read_bytes())
        self.run_voxshell('verify', 'out', code=3, err=r'cup\.vdb: comes from another source than cup\.voxmap')
        self.make('cup', shapes.cup(), '0.8mm', 'coarse')
        self.folder.joinpath('out/cup.vdb').write_bytes(self.folder.joinpath('coarse/cup.vdb').read_bytes())
        self.run_voxshell('verify', 'out', code=3, err=r'cup\.vdb: holds other cells or channels than cup\.voxmap')

    def test_against_its_mesh(self):
        for kind, measures in (('voxmap', 3), ('vdb', 3), ('pointshell', 6)):
            entry, by = self.against(f'out/cup.{kind}', 'cup.stl', 0, err='')
            self.assertTrue(entry['ok'] and entry['against']['same_source'])
            self.assertEqual(len(by), measures)
            for m in by.values():
                self.assertTrue(m['holds'] and m['binding'] and m['worst'] <= m['bound'] and m['places'] > 0, m)
        self.run_voxshell('verify', 'out', '--against', 'cup.stl', '--unit', 'mm', out='bound', err='')

    def test_channels_and_thinned_shells_against_their_mesh(self):
        self.run_voxshell('convert', 'cup.stl', '-o', 'extra', '--unit', 'mm', '--voxel', '0.7mm', '-q', '--channels', 'layers:2,distance:3',
                          '--thin-shell', '5')
        for kind, measures in (('voxmap', 5), ('vdb', 5), ('pointshell', 6)):
            _, by = self.against(f'extra/cup.{kind}', 'cup.stl', 0, err='')
            self.assertEqual(len(by), measures)
        shapes.write_stl(self.path('thicker.stl'), shapes.cup(wall=2.8))
        _, by = self.against('extra/cup.voxmap', 'thicker.stl', 6)
        self.assertFalse(by['distance channel against the mesh']['holds'])

    def test_against_a_mesh_that_differs(self):
        shapes.write_stl(self.path('thicker.stl'), shapes.cup(wall=2.8))
        entry, by = self.against('out/cup.voxmap', 'thicker.stl', 6)
        self.assertFalse(entry['ok'] or entry['against']['same_source'])
        self.assertGreater(by['surface cells that no triangle meets']['beyond'], 0)
        self.assertGreater(by['samples of the mesh outside surface cells']['beyond'], 0)
        _, by = self.against('out/cup.pointshell', 'thicker.stl', 6)
        # Wall and floor are 0.8 mm from where they were, the edge between them moved along the diagonal.
        self.assertAlmostEqual(by['distance of a point from the mesh']['worst'], 0.8e-3 * 2 ** 0.5, delta=0.01e-3)
        self.assertFalse(by['area of all points less that of the mesh']['holds'])

    def test_a_missing_half_is_noticed(self):
        """All that is there is right, and half is not there: only what goes from mesh to asset can tell."""
        shapes.write_stl(self.path('two.stl'), shapes.cup() + shapes.box(5, 5, 5, at=(100, 0, 0)))
        _, by = self.against('out/cup.voxmap', 'two.stl', 6)
        self.assertEqual(by['surface cells that no triangle meets']['beyond'], 0)
        self.assertGreater(by['samples of the mesh outside surface cells']['beyond'], 0)
        _, by = self.against('out/cup.pointshell', 'two.stl', 6)
        self.assertEqual(by['distance of a point from the mesh']['beyond'], 0)
        self.assertFalse(by['distance of the mesh from the nearest point']['holds'])

    def test_filled_where_it_should_be_hollow(self):
        """The same surface, another inside."""
        self.make('solid', shapes.box(20, 20, 20) + shapes.box(8, 8, 8, at=(6, 6, 6)), '0.7mm')
        shapes.write_stl(self.path('hollow.stl'), shapes.box(20, 20, 20) + shapes.flipped(shapes.box(8, 8, 8, at=(6, 6, 6))))
        _, by = self.against('out/solid.voxmap', 'hollow.stl', 6)
        self.assertEqual([m['holds'] for m in by.values()], [True, True, False])
        _, by = self.against('out/solid.voxmap', 'solid.stl', 0)

    def test_an_open_mesh_has_no_inside(self):
        self.make('sheet', shapes.box(20, 20, 20)[:10], '0.7mm')
        _, by = self.against('out/sheet.pointshell', 'sheet.stl', 0)
        self.assertFalse(by['share of normals that point outwards']['binding'])

    def test_against_needs_what_convert_needs(self):
        self.refused(1, 'unit', 'out/cup.voxmap', '--against', 'cup.stl', verb='verify')
        self.refused(2, 'none.stl', 'out/cup.voxmap', '--against', 'none.stl', '--unit', 'mm', verb='verify')


if __name__ == '__main__':
    command.main()
