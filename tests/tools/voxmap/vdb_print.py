# SPDX-License-Identifier: GPL-3.0-or-later
"""A .vdb as OpenVDB's own vdb_print sees it. Skipped where that program is not installed."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / 'cli'))
import shapes  # noqa: E402

if not shutil.which('vdb_print'):
    print('vdb_print is not here (package libopenvdb-tools)')
    sys.exit(77)

with tempfile.TemporaryDirectory(prefix='voxshell-') as folder:
    # 0.5..60.5 mm in cells of 1 mm is 0..60: 61^3 cells, which hold bricks that are solid.
    shapes.write_stl(f'{folder}/box.stl', shapes.box(60, 60, 60, at=(0.5, 0.5, 0.5)))
    subprocess.run([os.environ['VOXSHELL'], 'convert', 'box.stl', '-o', '.', '--unit', 'mm', '--voxel', '1mm', '-q'],
                   cwd=folder, check=True, stdout=subprocess.DEVNULL)
    done = subprocess.run(['vdb_print', '-l', 'box.vdb'], cwd=folder, capture_output=True, text=True, timeout=60)

said = done.stdout + done.stderr
missing = [pattern for pattern in (
    r'Name: state', r'Tree_int32_5_4_3', r'Background value: 0', r'Min value: 1', r'Max value: 2', r'unit: m\n', r'voxel: 0\.001\n',
    rf'Number of active voxels: +{61 ** 3:,}\n', r'Number of active tiles: +[1-9]', r'\[0, 0, 0\] -> \[60, 60, 60\]', r'voxel size: 0\.001\n',
    r'\[0\.0005, 0\.0005, 0\.0005, 1\]') if not re.search(pattern, said)]
if done.returncode or missing:
    print(f'exit {done.returncode}, not found: {missing}\n{said}')
    sys.exit(1)
