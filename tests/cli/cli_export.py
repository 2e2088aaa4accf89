# SPDX-License-Identifier: GPL-3.0-or-later
"""pack and export: what goes in comes out, read back here without the project's code."""
import csv
import json
import math
import struct

import command
import shapes


def read_ply(data):
    """Columns of the vertices, and the faces."""
    head, body = data.split(b'end_header\n', 1)
    lines = head.decode().splitlines()
    assert lines[:2] == ['ply', 'format binary_little_endian 1.0'], lines
    counts = {line.split()[1]: int(line.split()[2]) for line in lines if line.startswith('element')}
    types = [line.split()[1:] for line in lines if line.startswith('property') and 'list' not in line]
    row = struct.Struct('<' + ''.join({'float': 'f', 'double': 'd'}[t] for t, _ in types))
    vertices = [row.unpack_from(body, n * row.size) for n in range(counts['vertex'])]
    rest = body[counts['vertex'] * row.size:]
    faces = []
    for n in range(counts.get('face', 0)):
        size, *corners = struct.unpack_from('<B4i', rest, 17 * n)
        assert size == 4
        faces.append(tuple(corners))
    assert len(rest) == 17 * len(faces)
    return [name for _, name in types], vertices, faces


def read_glb(data):
    magic, version, size, json_size, json_kind = struct.unpack_from('<5I', data)
    assert (magic, version, size, json_kind, size % 4) == (0x46546c67, 2, len(data), 0x4e4f534a, 0)
    document = json.loads(data[20:20 + json_size])
    binary_size, kind = struct.unpack_from('<2I', data, 20 + json_size)
    assert kind == 0x4e4942 and 28 + json_size + binary_size == len(data)
    binary = data[28 + json_size:]
    assert document['buffers'][0]['byteLength'] <= binary_size

    def accessor(index):
        a = document['accessors'][index]
        view = document['bufferViews'][a['bufferView']]
        width = {'SCALAR': 1, 'VEC3': 3}[a['type']]
        flat = struct.unpack_from(f'<{width * a["count"]}{ {5125: "I", 5126: "f"}[a["componentType"]] }', binary, view['byteOffset'])
        assert view['byteLength'] == 4 * len(flat)
        values = [flat[n:n + width] for n in range(0, len(flat), width)]
        for key, pick in (('min', min), ('max', max)):
            if key in a:
                assert all(math.isclose(a[key][c], pick(v[c] for v in values), rel_tol=1e-6, abs_tol=1e-12) for c in range(width))
        return values

    return document, accessor


def volume(points, polygons):
    total = 0
    for polygon in polygons:
        for b, c in zip(polygon[1:], polygon[2:]):
            p, q, r = points[polygon[0]], points[b], points[c]
            total += (p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) + p[2] * (q[0] * r[1] - q[1] * r[0])) / 6
    return total


class Export(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.make('part', shapes.box(30, 20, 10, at=(0.5, -7.5, 0.5)))

    def make(self, name, triangles, voxel='1mm'):
        shapes.write_stl(self.path(name + '.stl'), triangles)
        self.run_voxshell('convert', name + '.stl', '-o', '.', '--unit', 'mm', '--voxel', voxel, '-q')

    def bytes_of(self, name):
        return self.folder.joinpath(name).read_bytes()

    def test_both_ways_without_loss(self):
        self.make('ball', shapes.sphere(), '0.3mm')
        self.make('cup', shapes.cup(), '0.47mm')
        for name in ('part', 'ball', 'cup'):
            self.run_voxshell('export', f'{name}.voxmap', '-o', f'back/{name}.vdb', err='', out=f'back/{name}.vdb')
            self.run_voxshell('pack', f'{name}.vdb', '-o', f'back/{name}.voxmap', err='', out=f'back/{name}.voxmap: .* surface')
            for ending in ('vdb', 'voxmap'):
                self.assertEqual(self.bytes_of(f'back/{name}.{ending}'), self.bytes_of(f'{name}.{ending}'), f'{name}.{ending}')

    def test_channels_both_ways_and_as_columns(self):
        self.run_voxshell('convert', 'part.stl', '-o', 'extra', '--unit', 'mm', '--voxel', '1mm', '-q', '--channels', 'layers:2,distance:3')
        self.run_voxshell('export', 'extra/part.voxmap', '-o', 'back/part.vdb')
        self.run_voxshell('pack', 'extra/part.vdb', '-o', 'back/part.voxmap')
        for ending in ('vdb', 'voxmap'):
            self.assertEqual(self.bytes_of(f'back/part.{ending}'), self.bytes_of(f'extra/part.{ending}'))
        self.run_voxshell('export', 'extra/part.voxmap', '-o', 'cells.csv')
        with open(self.path('cells.csv'), newline='') as file:
            header, *rows = list(csv.reader(file))
        self.assertEqual(header, ['i', 'j', 'k', 'state', 'layer', 'distance_m'])
        self.assertEqual(len(rows), 31 * 21 * 11)
        for i, j, k, state, layer, distance in rows:
            i, j, k = int(i), int(j), int(k)
            ring = min(i, 30 - i, j + 8, 12 - j, k, 10 - k)
            self.assertEqual((int(state), int(layer)), (2 if ring else 1, -min(ring, 3)))
            # Centres of surface cells lie on the box's sides, on its edges and corners too.
            self.assertAlmostEqual(float(distance), -min(ring, 3) * 1e-3, delta=1e-7)

    def test_pack_beside(self):
        self.folder.joinpath('other').mkdir()
        self.folder.joinpath('other/part.vdb').write_bytes(self.bytes_of('part.vdb'))
        self.run_voxshell('pack', 'other/part.vdb')
        self.assertEqual(self.bytes_of('other/part.voxmap'), self.bytes_of('part.voxmap'))

    def test_cells_as_table(self):
        self.run_voxshell('export', 'part.voxmap', '-o', 'cells.csv')
        with open(self.path('cells.csv'), newline='') as file:
            header, *rows = list(csv.reader(file))
        self.assertEqual(header, ['i', 'j', 'k', 'state'])
        # 0.5..30.5, -7.5..12.5, 0.5..10.5 mm in cells of 1 mm: 0..30, -8..12, 0..10, the outer layer surface.
        box = ((0, 30), (-8, 12), (0, 10))
        expected = [[i, j, k, 1 if any(c in ends for c, ends in zip((i, j, k), box)) else 2]
                    for i in range(31) for j in range(-8, 13) for k in range(11)]
        self.assertEqual([[int(n) for n in row] for row in rows], expected)
        self.run_voxshell('export', 'part.vdb', '-o', 'again.csv')
        self.assertEqual(self.bytes_of('again.csv'), self.bytes_of('cells.csv'))

    def test_cells_with_solid_bricks_as_table(self):
        self.make('big', shapes.box(60, 60, 60, at=(-20.5, 0.5, 0.5)))
        self.run_voxshell('export', 'big.voxmap', '-o', 'big.csv')
        with open(self.path('big.csv')) as file:
            next(file)
            rows = [tuple(map(int, line.split(','))) for line in file]
        self.assertEqual(len(rows), 61 ** 3)
        self.assertEqual(rows, sorted(rows))
        self.assertEqual(sum(row[3] == 2 for row in rows), 59 ** 3)

    def test_cells_as_picture(self):
        self.run_voxshell('export', 'part.voxmap', '-o', 'part.ply')
        names, points, quads = read_ply(self.bytes_of('part.ply'))
        self.assertEqual(names, ['x', 'y', 'z'])
        self.assertEqual(len(quads), 2 * (31 * 21 + 31 * 11 + 21 * 11))
        self.assertEqual(len(set(points)), len(points))
        directed = {}
        for quad in quads:
            for edge in zip(quad, quad[1:] + quad[:1]):
                directed[edge] = directed.get(edge, 0) + 1
        self.assertTrue(all(n == 1 and directed.get(edge[::-1]) == 1 for edge, n in directed.items()), 'skin is not closed')
        self.assertAlmostEqual(volume(points, quads), 31 * 21 * 11 * 1e-9, delta=1e-15)
        self.assertEqual(min(points), (0, -0.008, 0))

        self.run_voxshell('export', 'part.voxmap', '-o', 'part.glb')
        document, accessor = read_glb(self.bytes_of('part.glb'))
        primitive = document['meshes'][0]['primitives'][0]
        move = document['nodes'][0]['translation']
        corners = [tuple(x + t for x, t in zip(p, move)) for p in accessor(primitive['attributes']['POSITION'])]
        index = [n for n, in accessor(primitive['indices'])]
        self.assertAlmostEqual(volume(corners, list(zip(index[::3], index[1::3], index[2::3]))), 31 * 21 * 11 * 1e-9, delta=1e-12)

    def test_a_cavity_has_a_skin(self):
        hollow = shapes.box(20, 20, 20, at=(0.5, 0.5, 0.5)) + shapes.flipped(shapes.box(8, 8, 8, at=(6.5, 6.5, 6.5)))
        self.make('hollow', hollow)
        self.run_voxshell('export', 'hollow.voxmap', '-o', 'hollow.ply')
        _, points, quads = read_ply(self.bytes_of('hollow.ply'))
        self.assertAlmostEqual(volume(points, quads), (21 ** 3 - 7 ** 3) * 1e-9, delta=1e-15)

    def test_points(self):
        self.run_voxshell('export', 'part.pointshell', '-o', 'shell.ply')
        names, points, faces = read_ply(self.bytes_of('shell.ply'))
        self.assertEqual((names, faces), (['x', 'y', 'z', 'nx', 'ny', 'nz', 'area'], []))
        self.assertEqual(len(points), 31 * 21 * 11 - 29 * 19 * 9)
        self.assertAlmostEqual(sum(p[6] for p in points), 2 * (30 * 20 + 30 * 10 + 20 * 10) * 1e-6, delta=1e-9)
        for p in points:
            sides = (p[0] - 0.0005, 0.0305 - p[0], p[1] + 0.0075, 0.0125 - p[1], p[2] - 0.0005, 0.0105 - p[2])
            self.assertLess(abs(min(sides)), 1e-8)
            self.assertAlmostEqual(sum(c * c for c in p[3:6]), 1, delta=1e-6)
            self.assertGreater(sum((m - c) * n for c, n, m in zip(p, p[3:6], (0.0155, 0.0025, 0.0055))), 0)

        self.run_voxshell('export', 'part.pointshell', '-o', 'shell.csv')
        with open(self.path('shell.csv'), newline='') as file:
            header, *rows = list(csv.reader(file))
        self.assertEqual(header, names)
        as_float = struct.Struct('<7f')
        self.assertEqual([as_float.unpack(as_float.pack(*map(float, row))) for row in rows], points)

        self.run_voxshell('export', 'part.pointshell', '-o', 'shell.glb')
        document, accessor = read_glb(self.bytes_of('shell.glb'))
        primitive = document['meshes'][0]['primitives'][0]
        self.assertEqual(primitive['mode'], 0)
        columns = [accessor(primitive['attributes'][name]) for name in ('POSITION', 'NORMAL', '_AREA')]
        self.assertEqual([p + n + a for p, n, a in zip(*columns)], points)

    def test_refuses(self):
        self.refused(1, r'pointshell is exported as \.ply, \.glb, \.csv', 'part.pointshell', '-o', 'x.vdb', verb='export')
        self.refused(1, r'voxmap is exported as \.vdb, \.nvdb, \.ply, \.glb, \.csv', 'part.voxmap', '-o', 'x.obj', verb='export')
        self.refused(1, r'vdb is exported as \.voxmap', 'part.vdb', '-o', 'x', verb='export')
        self.refused(1, '-o', 'part.voxmap', verb='export')
        self.refused(1, r'pack writes \.voxmap', 'part.vdb', '-o', 'x.csv', verb='pack')
        self.refused(1, r'pack reads a \.vdb', 'part.voxmap', '-o', 'x.voxmap', verb='pack')
        self.refused(5, r'is not a \.voxmap', 'part.stl', '-o', 'x.ply', verb='export')
        self.refused(2, 'none.vdb', 'none.vdb', verb='pack')
        self.folder.joinpath('cut.vdb').write_bytes(self.bytes_of('part.vdb')[:3000])
        self.refused(3, 'cut.vdb', 'cut.vdb', verb='pack')

    def test_overwrites_only_with_force(self):
        self.folder.joinpath('x.csv').write_text('mine')
        self.refused(2, r'x\.csv: exists with other content', 'part.voxmap', '-o', 'x.csv', verb='export')
        self.assertEqual(self.bytes_of('x.csv'), b'mine')
        self.run_voxshell('export', 'part.voxmap', '-o', 'x.csv', '--force')
        whole = self.bytes_of('x.csv')
        self.run_voxshell('export', 'part.voxmap', '-o', 'x.csv')
        self.folder.joinpath('x.csv').write_bytes(whole + b'more')
        self.refused(2, r'x\.csv: exists with other content', 'part.voxmap', '-o', 'x.csv', verb='export')


if __name__ == '__main__':
    command.main()
