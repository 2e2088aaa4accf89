# SPDX-License-Identifier: GPL-3.0-or-later
"""How batch grows: batch.py VOXSHELL [--parts 1000]     N and 10 N different cups of 160 triangles in cells of 1 mm; then N on one thread.

Prints seconds and peak memory of the first run and of the next, which has nothing to do, and what ten times the parts take.
"""
import argparse
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / 'cli'))
import shapes


def make(folder, parts):
    dice = random.Random(5)
    for n in range(parts):
        place = folder / f'{n // 100:03d}'
        place.mkdir(parents=True, exist_ok=True)
        shapes.write_stl(place / f'part{n}.stl', shapes.cup(radius=8 + 6 * dice.random(), height=10 + 10 * dice.random(), wall=2, segments=16))


def run(voxshell, folder, out, *options):
    """Seconds and peak [MiB]."""
    began = time.monotonic()
    child = subprocess.Popen([voxshell, 'batch', folder, '-o', out, '--unit', 'mm', '--voxel', '1mm', '-q', *options])
    _, status, usage = os.wait4(child.pid, 0)
    if status:
        sys.exit(f'batch ended with {os.waitstatus_to_exitcode(status)}')
    return time.monotonic() - began, usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('voxshell')
    parser.add_argument('--parts', type=int, default=1000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix='voxshell-') as name:
        root, first = pathlib.Path(name), None
        print('| parts | threads | seconds | peak MiB | again, seconds |\n|---|---|---|---|---|')
        for parts, threads in ((options.parts, '1'), (options.parts, '0'), (10 * options.parts, '0')):
            folder, out = root / str(parts), root / f'out{parts}-{threads}'
            if not folder.exists():
                make(folder, parts)
            seconds, peak = run(options.voxshell, folder, out, '-j', threads)
            again, _ = run(options.voxshell, folder, out, '-j', threads)
            print(f'| {parts} | {"all" if threads == "0" else threads} | {seconds:.1f} | {peak:.0f} | {again:.2f} |', flush=True)
            if threads == '0':
                first, ratio = first or seconds, seconds / (first or seconds)
        print(f'\nTen times the parts take {ratio:.1f} times as long.')


if __name__ == '__main__':
    main()
