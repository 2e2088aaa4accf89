# SPDX-License-Identifier: GPL-3.0-or-later
"""samples/golden_files as its user meets it: build, accept, pass; change a part, fail with what moved; accept again."""
import os
import pathlib
import shutil
import subprocess

import command
import shapes


class GoldenFiles(command.CommandTest):
    def run_cmake(self, program, *arguments, fails=False):
        done = subprocess.run([program, *arguments], cwd=self.path('mine'), capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(done.returncode != 0, fails, done.stdout + done.stderr)
        return done.stdout

    def test_as_its_user_does(self):
        shutil.copytree(command.SOURCE / 'samples/golden_files', self.path('mine'))
        os.mkdir(self.path('mine', 'parts'))
        shapes.write_stl(self.path('mine', 'parts', 'cup.stl'), shapes.cup(radius=20, segments=24))
        shapes.write_glb(self.path('mine', 'parts', 'ball.glb'), shapes.sphere(radius=15))
        lists = pathlib.Path(self.path('mine', 'CMakeLists.txt'))
        lists.write_text(lists.read_text(encoding='utf-8').replace('${CMAKE_CURRENT_SOURCE_DIR}/../../tools/cmake', str(command.SOURCE / 'tools/cmake')), encoding='utf-8')
        self.run_cmake('cmake', '-S', '.', '-B', 'build', '-G', 'Ninja', f'-DVOXSHELL_EXECUTABLE={command.BIN}')
        self.assertIn('2 built, 0 failed', self.run_cmake('cmake', '--build', 'build'))
        self.assertIn('no work to do', self.run_cmake('cmake', '--build', 'build'))
        self.run_cmake('ctest', '--test-dir', 'build', fails=True)  # nothing was accepted yet
        self.run_cmake('cmake', '--build', 'build', '--target', 'accept')
        self.assertIn('100% tests passed', self.run_cmake('ctest', '--test-dir', 'build'))
        shapes.write_stl(self.path('mine', 'parts', 'cup.stl'), shapes.cup(radius=20, height=30.5, segments=24))
        self.assertIn('1 built, 1 up to date, 0 failed', self.run_cmake('cmake', '--build', 'build'))
        said = self.run_cmake('ctest', '--test-dir', 'build', '--output-on-failure', fails=True)
        self.assertIn('cup.pointshell\n', said)
        self.assertIn('the largest change 0.5 mm', said)
        self.assertIn('5 equal, 1 differ, 0 only in', said)  # the same cells
        self.assertIn('67% tests passed', said)  # within half a cell it is what it was
        self.run_cmake('cmake', '--build', 'build', '--target', 'accept')
        self.run_cmake('ctest', '--test-dir', 'build')


if __name__ == '__main__':
    command.main()
