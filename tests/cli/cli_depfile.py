# SPDX-License-Identifier: GPL-3.0-or-later
"""--depfile as make, ninja and CMake read it: what a result was made of runs the command again, and nothing else does."""
import json
import os
import pathlib
import shutil
import subprocess
import time
import unittest

import command
import shapes
from cli_scene import SCENE

CUP = shapes.cup(radius=20, height=30, wall=4, segments=16)


class Depfile(command.CommandTest):
    def assembly(self, name):
        path = pathlib.Path(self.path(name))
        path.parent.mkdir(parents=True, exist_ok=True)
        return shapes.write_assembly(path, [('cup', CUP)], [{'mesh': 0}])

    def run_tool(self, *arguments, fails=False):
        if not shutil.which(arguments[0]):
            raise unittest.SkipTest(f'{arguments[0]} is not here')
        done = subprocess.run(arguments, cwd=self.folder, capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(done.returncode != 0, fails, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def changed(self, *name):
        """As an editor saves it: now, and later than all that a file system tells apart."""
        time.sleep(0.02)
        os.utime(self.path(*name))

    def write(self, name, text):
        pathlib.Path(self.path(name)).write_text(text, encoding='utf-8')

    def test_make(self):
        name = 'in/cup #1 of $2'
        self.assembly(f'{name}.gltf')
        self.write('in/texture.png', '')
        self.run_voxshell('convert', f'{name}.gltf', '-o', 'out', '--voxel', '4mm', '-q', '--depfile', 'd.d')
        # make itself says what it has read.
        self.write('say.mk', 'include d.d\nsay: ; @:\n')
        said = self.run_tool('make', '-f', 'say.mk', '-p', 'say')
        for ending in ('vdb', 'voxmap', 'pointshell'):
            line = next(line for line in said.splitlines() if line.startswith(f'out/cup #1 of $2.{ending}:') or line.startswith(f'out/cup \\#1 of $2.{ending}:'))
            self.assertIn(f'{name}.gltf', line.replace('\\', ''))
            self.assertIn(f'{name}.bin', line.replace('\\', ''))
            self.assertNotIn('texture', line)

    def rounds(self, run, ran, target, source, other):
        """A target is made once, again when its source changed, and not for another file."""
        self.assertIn(ran, run())
        self.assertNotIn(ran, run())
        self.changed(source)
        self.assertIn(ran, run())  # the same bytes come out of it: it is made all the same
        self.assertNotIn(ran, run())
        self.changed(other)
        self.assertNotIn(ran, run())
        os.unlink(self.path(source))
        self.assertIn('robot.gltf: ', run(fails=True))
        self.assertIn('robot.gltf: ', run(fails=True))  # a run that failed has not made it
        self.assembly('in/robot.gltf')
        self.assertIn(ran, run())
        self.assertNotIn(ran, run())
        self.assertTrue(os.path.exists(self.path(target)))

    def test_make_batch(self):
        self.assembly('in/robot.gltf')
        self.write('other.bin', '')
        self.write('Makefile', f'out/manifest.json: ; "{command.BIN}" batch in/robot.gltf -o out --per-part --voxel 4mm --depfile robot.d\n-include robot.d\n')
        self.rounds(lambda **more: self.run_tool('make', **more), 'voxshell', 'out/robot/cup.voxmap', 'in/robot.bin', 'other.bin')

    def test_ninja_convert(self):
        self.assembly('in/robot.gltf')
        self.write('other.bin', '')
        self.write('build.ninja', f'rule convert\n command = {command.BIN} convert in/robot.gltf -o out --voxel 4mm --depfile $out.d\n depfile = $out.d\n'
                   'build out/robot.vdb | out/robot.voxmap out/robot.pointshell: convert\n')
        self.rounds(lambda **more: self.run_tool('ninja', '-v', **more), 'wrote', 'out/robot.voxmap', 'in/robot.bin', 'other.bin')

    def test_cmake(self):
        for generator in ('Ninja', 'Unix Makefiles'):
            with self.subTest(generator):
                shutil.rmtree(self.path('build'), ignore_errors=True)
                self.assembly('in/robot.gltf')
                self.write('other.bin', '')
                self.write('CMakeLists.txt', 'cmake_minimum_required(VERSION 3.25)\nproject(mine LANGUAGES NONE)\n'
                           f'list(APPEND CMAKE_MODULE_PATH {command.SOURCE}/tools/cmake)\ninclude(VoxshellAssets)\n'
                           'voxshell_assets(robot INPUTS in/robot.gltf OUTPUT assets VOXEL 4mm OPTIONS --per-part)\n')
                self.run_tool('cmake', '-B', 'build', '-G', generator, f'-DVOXSHELL_EXECUTABLE={command.BIN}')
                self.rounds(lambda **more: self.run_tool('cmake', '--build', 'build', **more), ', 0 failed', 'build/assets/robot/cup.voxmap', 'in/robot.bin', 'other.bin')

    def test_a_folder_and_a_part_that_fails(self):
        shapes.write_stl(self.path('a.stl'), CUP)
        os.makedirs(self.path('in', 'sub'))
        os.rename(self.path('a.stl'), self.path('in', 'a.stl'))
        self.write('Makefile', f'out/manifest.json: ; "{command.BIN}" batch in -o out --unit mm --voxel 4mm --depfile in.d\n-include in.d\n')
        self.assertIn('1 built', self.run_tool('make'))
        self.assertIn('up to date.\n', self.run_tool('make'))
        time.sleep(0.02)
        shapes.write_stl(self.path('in', 'sub', 'b.stl'), CUP)  # a file more in a folder
        self.assertIn('1 from the cache, 1 up to date', self.run_tool('make'))
        time.sleep(0.02)
        self.write('in/sub/bad.stl', 'solid\nfacet')
        for _ in range(2):
            self.assertIn('1 failed', self.run_tool('make', fails=True))
        os.unlink(self.path('in', 'sub', 'bad.stl'))
        self.assertIn('2 up to date, 0 failed', self.run_tool('make'))
        self.assertIn("is up to date.\n", self.run_tool('make'))

    def test_a_scene(self):
        shapes.write_assembly(self.path('cup.gltf'), [('cup', CUP)], [{'mesh': 0}])
        shapes.write_glb(self.path('sphere.glb'), shapes.sphere(radius=8))
        scene = {**SCENE, 'static': [{'file': 'cup.gltf'}]}
        self.write('press.scene.json', json.dumps(scene))
        self.run_voxshell('convert', 'press.scene.json', '-o', 'out', '-q', '--depfile', 'press.d')
        targets, sources = pathlib.Path(self.path('press.d')).read_text(encoding='utf-8').replace('\\\n', '').split('\n')[0].split(':')
        self.assertEqual(targets.split(), [f'out/press.{ending}' for ending in ('vdb', 'voxmap', 'pointshell', 'plan')])
        self.assertEqual(sorted(sources.split()), ['cup.bin', 'cup.gltf', 'press.scene.json', 'sphere.glb'])

    def test_refused(self):
        shapes.write_stl(self.path('a.stl'), CUP)
        os.rename(self.path('a.stl'), self.path('a\nb.stl'))
        self.run_voxshell('convert', 'a\nb.stl', '-o', 'out', '--unit', 'mm', '--voxel', '4mm', '--depfile', 'd', code=5, err='depfile cannot name')
        os.rename(self.path('a\nb.stl'), self.path('a.stl'))
        self.refused(2, 'nowhere: is not|nowhere|permission|not a folder', 'a.stl', '-o', 'out', '--unit', 'mm', '--voxel', '4mm', '--depfile', 'a.stl/d')


if __name__ == '__main__':
    command.main()
