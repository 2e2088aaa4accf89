# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts the open CAD files, verifies what came out, measures it again on the mesh, and prints a table.

convert_table.py VOXSHELL DATA [--cells 128]     DATA: the folder with MANIFEST.tsv; longest side in cells
Ends with 1 if any file fails to convert, to verify, or to verify --against its mesh.
"""
import argparse
import csv
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time


def rows_of(data):
    with open(data / 'MANIFEST.tsv', encoding='utf-8') as f:
        for row in csv.DictReader(f, delimiter='\t'):
            if row['path'].startswith(('cad/', 'stl/')) and row['expected'] == 'convert':
                yield row['path'], max(float(x) for x in re.findall(r'[\d.]+(?:e[-+]?\d+)?', row['bbox_size'])[:3])


def convert(voxshell, data, path, size, cells):
    stl = path.lower().endswith('.stl')
    unit = ['--unit', 'mm'] if stl else []
    mesh = data / path
    with tempfile.TemporaryDirectory(prefix='voxshell-') as folder:
        began = time.monotonic()
        done = subprocess.run([voxshell, 'convert', mesh, '-o', folder, '-q', '--voxel', f'{size / cells:.6g}{"mm" if stl else "m"}',
                               '--report', f'{folder}/report.json', *unit], capture_output=True, text=True, check=False)
        seconds = time.monotonic() - began
        if done.returncode:
            return None, done.stderr.strip()
        part = json.loads(pathlib.Path(folder, 'report.json').read_text(encoding='utf-8'))['parts'][0]
        pathlib.Path(folder, 'report.json').unlink()
        checks = [[voxshell, 'verify', folder], *([voxshell, 'verify', asset, '--against', mesh, *unit]
                                                  for asset in sorted(pathlib.Path(folder).iterdir()) if asset.suffix != '.vdb')]
        for check in checks:
            done = subprocess.run(check, capture_output=True, text=True, check=False)
            if done.returncode:
                return None, f'{check[1]}: {(done.stdout + done.stderr).strip()}'
    return (part, seconds), ''


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('voxshell', type=pathlib.Path)
    parser.add_argument('data', type=pathlib.Path)
    parser.add_argument('--cells', type=int, default=128)
    o = parser.parse_args()
    print('| file | triangles | closed | surface cells | interior cells | points | gap [voxels] | off the surface [voxels] | seconds |')
    print('|---|---|---|---|---|---|---|---|---|')
    good = total = 0
    for path, size in rows_of(o.data):
        total += 1
        made, why = convert(o.voxshell.resolve(), o.data.resolve(), path, size, o.cells)
        if not made:
            print(f'| {path} | {why} |')
            continue
        good += 1
        part, seconds = made
        print(f'| {path} | {part["triangles"]} | {"yes" if part["closed"] else "no"} | {part["surface_cells"]} | {part["interior_cells"]} | '
              f'{part["points"]} | {part["gap_max_h"]:.2f} | {part["surface_error_max_m"] / part["voxel_m"]:.1e} | {seconds:.2f} |')
    print(f'\n{good} of {total} converted, verified, and measured again on their mesh')
    return int(good != total)


if __name__ == '__main__':
    sys.exit(main())
