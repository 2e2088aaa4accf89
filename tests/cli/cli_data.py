# SPDX-License-Identifier: GPL-3.0-or-later
"""Open CAD files through convert and verify; skipped where the data set is not there."""
import csv
import os
import pathlib
import re
import unittest

import command

DATA = pathlib.Path(os.environ.get('VOXSHELL_DATA', 'none'))
FOLDERS = ('cad/', 'stl/')


def parts():
    manifest = DATA / 'MANIFEST.tsv'
    if not manifest.exists():
        return []
    with open(manifest, encoding='utf-8') as file:
        rows = list(csv.DictReader(file, delimiter='\t'))
    return [row for row in rows if row['expected'] == 'convert' and row['path'].startswith(FOLDERS)
            and row['path'].lower().endswith(('.stl', '.gltf', '.glb'))]


class Data(command.CommandTest):
    @unittest.skipUnless(parts(), 'the data set is not here')
    def test_converts_and_verifies(self):
        for row in parts():
            size = max(float(x) for x in re.findall(r'[\d.]+(?:e[-+]?\d+)?', row['bbox_size'])[:3])
            stl = row['path'].lower().endswith('.stl')
            name = pathlib.Path(row['path']).stem
            with self.subTest(path=row['path']):
                self.run_voxshell('convert', DATA / row['path'], '-o', name, '--voxel', f'{size / 96:.9g}{"mm" if stl else "m"}',
                                  *(['--unit', 'mm'] if stl else []), '--report', f'{name}/report.json')
                self.run_voxshell('verify', name)
                report = self.load(name, 'report.json')
                self.assertLessEqual(report['parts'][0]['gap_max_h'], 3.000001)


if __name__ == '__main__':
    command.main()
