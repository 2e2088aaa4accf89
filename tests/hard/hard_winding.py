# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts that overlap themselves are solid once: each cell without surface beside the generalised winding number at
its centre, summed triangle by triangle here, and no normal that leads out of the solid.

    hard_winding.py [CELLS...]      along the longest side; 48 unless told

An even-odd count of crossings calls doubly covered space outside; METHOD section 1 does not. These are the hard parts
where the two differ."""
import csv
import os
import pathlib
import subprocess
import sys
import tempfile

SKIPPED = 77
try:
    import numpy
except ImportError:
    print('numpy is not there')
    sys.exit(SKIPPED)

BIN = os.environ.get('VOXSHELL', 'voxshell')
DATA = pathlib.Path(os.environ.get('VOXSHELL_DATA', 'none'))
PARTS = ('three_cubes_overlapping.stl', 'thingi10k_1004825.stl')


def triangles(path):
    raw = path.read_bytes()
    return numpy.frombuffer(raw, offset=84, dtype=[('n', '<3f4'), ('v', '<9f4'), ('a', '<u2')])['v'].reshape(-1, 3, 3).astype(float)


def winding(mesh, points):
    """Solid angles by van Oosterom and Strackee, over the full sphere's."""
    total = numpy.zeros(len(points))
    for corners in mesh:
        a, b, c = (corner - points for corner in corners)
        la, lb, lc = (numpy.sqrt((v * v).sum(1)) for v in (a, b, c))
        volume = (a * numpy.cross(b, c)).sum(1)
        total += numpy.arctan2(volume, la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb)
    return total / (2 * numpy.pi)


def shell(path):
    head, body = path.read_bytes().split(b'end_header\n', 1)
    count = int(next(line for line in head.split(b'\n') if line.startswith(b'element vertex')).split()[2])
    names = [line.split()[1:] for line in head.split(b'\n') if line.startswith(b'property')]
    table = numpy.frombuffer(body, count=count, dtype=[(name.decode(), {b'float': '<f4', b'double': '<f8'}[kind]) for kind, name in names])
    return tuple(numpy.stack([table[name].astype(float) for name in each], 1) for each in (('x', 'y', 'z'), ('nx', 'ny', 'nz')))


def check(path, cells):
    mesh = triangles(path)
    voxel = float(f'{numpy.ptp(mesh.reshape(-1, 3), axis=0).max() / cells:.6g}')
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder)
        for command in (('convert', path, '-o', out, '--unit', 'mm', '--voxel', f'{voxel}mm', '-q'),
                        ('export', out / (path.stem + '.voxmap'), '-o', out / 'cells.csv'),
                        ('export', out / (path.stem + '.pointshell'), '-o', out / 'shell.ply')):
            subprocess.run([BIN, *map(str, command)], check=True, capture_output=True)
        with open(out / 'cells.csv', newline='') as file:
            rows = list(csv.reader(file))[1:]
        points, normals = shell(out / 'shell.ply')
    told = numpy.array([[int(x) for x in row[:4]] for row in rows])
    low, high = told[:, :3].min(0) - 1, told[:, :3].max(0) + 2
    state = numpy.zeros(high - low, dtype=int)
    state[tuple((told[:, :3] - low).T)] = told[:, 3]
    where = numpy.argwhere(state != 1)
    w = numpy.abs(winding(mesh, (where + low + 0.5) * voxel))
    solid = state[tuple(where.T)] == 2
    wrong = int((solid != (w >= 0.5)).sum())
    step = 1e-3 * voxel * normals
    ahead, behind = (numpy.abs(winding(mesh, points * 1e3 + side * step)) >= 0.5 for side in (1, -1))
    outwards = int((behind & ~ahead).sum())
    print(f'{path.name} at {cells}: {len(where)} cells without surface, {int(solid.sum())} interior, {int((w > 1.5).sum())} of them covered more '
          f'than once; {wrong} differ from the winding number; {len(points)} points, {int((ahead & behind).sum())} within the solid, '
          f'{int((ahead & ~behind).sum())} inwards, {outwards} outwards')
    return wrong == 0 and outwards == 0


def main():
    parts = [path for name in PARTS for path in sorted(DATA.rglob(name))]
    if not parts:
        print('no hard data')
        return SKIPPED
    ok = [check(path, cells) for cells in map(int, sys.argv[1:] or ['48']) for path in parts]
    return 0 if all(ok) else 1


if __name__ == '__main__':
    sys.exit(main())
