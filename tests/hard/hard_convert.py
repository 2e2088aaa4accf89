# SPDX-License-Identifier: GPL-3.0-or-later
"""Every hard file through the command line: converted with unit normals and within the estimated memory,
or refused with one clear line. Each conversion is a process of its own, whose peak the system tells."""
import functools
import json
import os
import pathlib
import random
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / 'cli'))
import command

BIN = os.environ.get('VOXSHELL', 'voxshell')
DATA = pathlib.Path(os.environ.get('VOXSHELL_DATA', 'none'))
CELLS = (48, 256)  # along the longest side
SKIPPED = 77


# Read in a process of its own: what a parent holds counts as the peak of its children.
READ = """
import math, struct, sys, numpy
what, name = sys.argv[1:]
raw = open(name, 'rb').read()
if what == 'extent':  # longest side of an STL file in its own unit
    if len(raw) >= 84 and len(raw) == 84 + 50 * struct.unpack_from('<I', raw, 80)[0]:
        points = numpy.frombuffer(raw, offset=84, dtype=[('n', '<3f4'), ('v', '<9f4'), ('a', '<u2')])['v'].reshape(-1, 3)
    else:
        points = numpy.array([line.split()[1:4] for line in raw.split(b'\\n') if line.split()[:1] == [b'vertex']], dtype=float)
    print(float((points.max(axis=0) - points.min(axis=0)).max()))
else:  # how far a normal of an exported shell is off unit length
    head, body = raw.split(b'end_header\\n', 1)
    count = int(next(line for line in head.split(b'\\n') if line.startswith(b'element vertex')).split()[2])
    names = [line.split()[1:] for line in head.split(b'\\n') if line.startswith(b'property')]
    table = numpy.frombuffer(body, count=count, dtype=[(name.decode(), {b'float': '<f4', b'double': '<f8'}[kind]) for kind, name in names])
    print(float(numpy.abs(numpy.sqrt(sum(table[name].astype(float) ** 2 for name in ('nx', 'ny', 'nz'))) - 1).max()))
"""


@functools.cache
def with_numpy():
    """An interpreter that has it: this one, or the system's."""
    for interpreter in dict.fromkeys((sys.executable, '/usr/bin/python3')):
        if os.path.exists(interpreter) and subprocess.run([interpreter, '-c', 'import numpy'], stderr=subprocess.DEVNULL, check=False).returncode == 0:
            return interpreter
    print('skipped: no Python 3 with numpy (Debian: python3-numpy)')
    sys.exit(SKIPPED)


def read(what, path):
    return float(subprocess.run([with_numpy(), '-c', READ, what, path], check=True, capture_output=True, text=True).stdout)


def run(*arguments):
    """Exit code, stderr, stdout and peak resident bytes of one run."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen([BIN, *map(str, arguments)], stdout=out, stderr=err, stdin=subprocess.DEVNULL)
        pid, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0), err.seek(0)
        return process.returncode, err.read().decode(), out.read().decode(), usage.ru_maxrss * 1024


def check(path, folder, cells):
    """Problems found, and peak / estimate (0: refused)."""
    stl = path.suffix.lower() == '.stl'
    size = read('extent', path) if stl else 1.0
    arguments = [path, '--voxel', f'{size / cells:.9g}{"mm" if stl else "m"}', *(['--unit', 'mm'] if stl else []), '-j', '2']
    code, said, told, _ = run('convert', *arguments, '-o', folder / 'no', '--dry-run', '--format', 'json')
    estimate = json.loads(told)['estimates'][0]['memory_bytes'] if code == 0 else 0
    code, said, told, peak = run('convert', *arguments, '-o', folder / 'out', '--force')
    if code in (3, 4, 5):
        errors = [line for line in said.splitlines() if ': error: ' in line]
        return ([] if len(errors) == 1 and path.name in errors[0] and not estimate else [f'refused, but not in one clear line: {said}']), 0
    if code:
        return [f'exit {code}: {said}'], 0
    bad = []
    if peak > estimate and not command.sanitized():
        bad.append(f'{peak >> 20} MiB, estimated {estimate / 2**20:.0f} MiB')
    run('export', folder / 'out' / f'{path.stem}.pointshell', '-o', folder / 'shell.ply', '--force')
    off = read('normals', folder / 'shell.ply')
    if not off <= 1e-6:
        bad.append(f'a normal is off unit length by {off:.2g}')
    return bad, peak / estimate


def dust(path, size, count=30000):
    """Unconnected triangles of about `size` anywhere in a box of 1000: their area says nothing of the cells that they cost."""
    dice = random.Random(7)
    with open(path, 'wb') as file:
        file.write(bytes(80) + struct.pack('<I', count))
        for _ in range(count):
            at = [dice.uniform(0, 1000) for _ in range(3)]
            corners = [x + dice.uniform(-size, size) / 2 for _ in range(3) for x in at]
            file.write(struct.pack('<12fH', 0, 0, 0, *corners, 0))
    return path


def check_dust(folder):
    """A triangle a cell, many a cell, one a brick, and one a chunk; problems found."""
    bad = []
    for size, cells in ((0.3, 20), (0.3, 30), (0.3, 256), (3, 1000), (0.3, 2500)):
        found, ratio = check(dust(folder / f'dust-{size}-{cells}.stl', size), folder, cells)
        print(f'dust of {size / 1000 * cells:.2g} cells in a box of {cells}: peak / estimate {ratio:.2f}', flush=True)
        bad += [f'dust, {cells} cells: {line}' for line in found]
        if not ratio > 0.4 and not command.sanitized():
            bad.append(f'dust, {cells} cells: the estimate is {1 / ratio:.2f} times the peak')
    return bad


def main():
    with tempfile.TemporaryDirectory() as name:
        dusty = check_dust(pathlib.Path(name))
    print(*dusty, sep='\n')
    files = sorted(path for path in (DATA / 'hard').rglob('*') if path.is_file())
    if not files:
        print('skipped: the shared data are not here')
        sys.exit(1 if dusty else SKIPPED)
    failed, ratios, refused = len(dusty), [], 0
    with tempfile.TemporaryDirectory() as name:
        for path in files:
            for cells in CELLS:
                bad, ratio = check(path, pathlib.Path(name), cells)
                if ratio:
                    ratios.append(ratio)
                refused += not ratio
                failed += bool(bad)
                for line in bad:
                    print(f'{path.name} at {cells} cells: {line}', flush=True)
    print(f'{len(files)} files at {CELLS} cells: {len(ratios)} converted, {refused} refused, peak / estimate {min(ratios):.2f} to {max(ratios):.2f}')
    sys.exit(failed != 0)


if __name__ == '__main__':
    main()
