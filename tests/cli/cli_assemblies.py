# SPDX-License-Identifier: GPL-3.0-or-later
"""Assemblies of other people's CAD programs, part by part: how many distinct parts each has, nothing to do the second time, and Draco's twin."""
import json
import os
import pathlib
import unittest

import command

DATA = pathlib.Path(os.environ.get('VOXSHELL_DATA', 'none'), 'cad')

# Distinct parts and instances, counted once by a script that shares no code with the tool: meshes of the same bytes, times their stretch.
ASSEMBLIES = [
    ('cookiefactory_watertank.glb', 16, 21, 'auto'),
    ('frc_kitbot.glb', 2, 2, 'auto'),
    ('CesiumMilkTruck_draco/CesiumMilkTruck.gltf', 2, 3, 'auto'),
    ('retroufo_cadexchanger.glb', 45, 77, '1m'),
    ('NegativeScaleTest.glb', 7, 11, 'auto'),
    ('SimpleInstancing/SimpleInstancing.gltf', 125, 125, 'auto'),
    ('SharpGLTF_InstanceTest.glb', 1117, 2500, '0.05m'),  # 2500 poses of one mesh, in 1117 sizes
]


@unittest.skipUnless(DATA.exists(), 'the data set is not here')
class Assemblies(command.CommandTest):
    def test_distinct_parts(self):
        for file, parts, instances, voxel in ASSEMBLIES:
            with self.subTest(file):
                name = pathlib.Path(file).stem
                arguments = (DATA / file, '-o', name, '--per-part', '--voxel', voxel)
                self.run_voxshell('batch', *arguments, out=f'^{parts:_} built, 0 failed\n$'.replace('_', ' '))
                assembly = json.loads(pathlib.Path(self.path(name, name, 'assembly.json')).read_text(encoding='utf-8'))
                self.assertEqual((len(assembly['parts']), len(assembly['instances'])), (parts, instances))
                self.assertEqual(sum(part['instances'] for part in assembly['parts']), instances)
                self.run_voxshell('batch', *arguments, out='^0 built, .* up to date, 0 failed\n$')

    def test_draco_s_twin(self):
        """11 bits over 1357 m are steps of 0.663 m: no point is further from the plain mesh than half a step on each axis."""
        for kind in ('plain', 'draco'):
            self.run_voxshell('convert', DATA / f'reveal_plant_{kind}.glb', '-o', kind, '--voxel', '4m', '-q')
        done = self.run_voxshell('verify', 'draco/reveal_plant_draco.pointshell', '--against', DATA / 'reveal_plant_plain.glb', '--format', 'json', code=6)
        measures = {m['what']: m['worst'] for m in json.loads(done.stdout)['files'][0]['against']['measures']}
        self.assertLess(measures['distance of a point from the mesh'], 3 ** 0.5 / 2 * 1357 / 2047)
        self.run_voxshell('diff', 'plain/reveal_plant_plain.pointshell', 'draco/reveal_plant_draco.pointshell', '--tolerance', '4m', out='equal\n$')


if __name__ == '__main__':
    command.main()
