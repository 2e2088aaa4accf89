# SPDX-License-Identifier: GPL-3.0-or-later
"""pack with grids of other programs: what users see, say and get, and what a damaged file leaves behind."""
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import unittest

import command

FOREIGN = pathlib.Path(os.environ.get('VOXSHELL_BUILD', '.'), 'bin', 'foreign_vdb')


class Pack(command.CommandTest):
    def make(self, kind, name=None):
        subprocess.run([FOREIGN, kind, self.path(f'{name or kind}.vdb')], check=True, timeout=60)

    def inspect(self, name):
        return json.loads(self.run_voxshell('inspect', name, '--format', 'json').stdout)

    def cells(self, name):
        self.run_voxshell('export', name, '-o', 'cells.csv', '--force')
        with open(self.path('cells.csv'), encoding='utf-8') as file:
            next(file)
            return {tuple(map(int, line.split(',')[:3])): int(line.split(',')[3]) for line in file}

    def test_a_level_set(self):
        self.make('ball')  # radius 20 in voxels of 1, index 0 at the origin
        self.run_voxshell('pack', 'ball.vdb', '--unit', 'mm', out=r'ball\.voxmap: [\d ]+ surface, [\d ]+ interior cells of 1 um',
                          err=r'^voxshell pack: warning: ball\.vdb: the distances of level set `ball` .*--snap')
        self.run_voxshell('pack', 'ball.vdb', '-o', 'metres.voxmap', '-q', err='', out='')
        self.assertEqual(self.inspect('metres.voxmap')['voxel_m'], 0.001)
        self.run_voxshell('verify', 'metres.voxmap')
        cells = self.cells('metres.voxmap')
        for (i, j, k), state in cells.items():
            corners = [(i + a) ** 2 + (j + b) ** 2 + (k + c) ** 2 for a in (0, 1) for b in (0, 1) for c in (0, 1)]
            self.assertEqual(state, 2 if max(corners) < 400 else 1)
            self.assertLess(min(corners), 400)
        self.assertEqual(len(cells), sum(
            any((i + a) ** 2 + (j + b) ** 2 + (k + c) ** 2 < 400 for a in (0, 1) for b in (0, 1) for c in (0, 1))
            for i in range(-21, 21) for j in range(-21, 21) for k in range(-21, 21)))

    def test_snapped_with_its_distances(self):
        self.make('ball')
        self.run_voxshell('pack', 'ball.vdb', '--snap', err=r'warning: ball\.vdb: grid `ball` was moved by \(0\.5 mm, 0\.5 mm, 0\.5 mm\)')
        found = self.inspect('ball.voxmap')
        self.assertEqual(found['channels'], ['distance'])
        self.run_voxshell('verify', 'ball.voxmap')
        text = self.run_voxshell('inspect', 'ball.voxmap').stdout
        self.assertIn('"moved_m":[0.0005,0.0005,0.0005]', text)
        # There and back through our own .vdb: the same bytes.
        self.run_voxshell('export', 'ball.voxmap', '-o', 'own/ball.vdb')
        self.run_voxshell('pack', 'own/ball.vdb', '-o', 'again.voxmap', err='')
        self.assertEqual(self.folder.joinpath('again.voxmap').read_bytes(), self.folder.joinpath('ball.voxmap').read_bytes())

    def test_one_of_several_grids_and_masks(self):
        self.make('two')
        self.refused(1, r'two\.vdb: holds 2 grids: --grid names one of `ball` \(level set\), `mask` \(mask\)', 'two.vdb', verb='pack')
        self.refused(1, r'has no grid `x`; --grid names one of', 'two.vdb', '--grid', 'x', verb='pack')
        self.refused(5, r'--snap moves it by \(0\.5, 0\.5, 0\.5\) voxels', 'two.vdb', '--grid', 'mask', verb='pack')
        self.run_voxshell('pack', 'two.vdb', '--grid', 'mask', '--snap', '-o', 'solid.voxmap')
        solid = self.cells('solid.voxmap')
        self.assertEqual(solid, {(i, j, k): 2 if 0 < i < 20 and 0 < j < 10 and 0 < k < 3 else 1
                                 for i in range(21) for j in range(11) for k in range(4)})
        self.run_voxshell('pack', 'two.vdb', '--grid', 'mask', '--snap', '--as', 'surface', '-o', 'surface.voxmap')
        self.assertEqual(self.cells('surface.voxmap'), dict.fromkeys(solid, 1))
        self.make('same-names')
        self.refused(1, r'holds 2 grids: --grid names one of `mask\[0\]` \(mask\), `mask\[1\]` \(mask\)', 'same-names.vdb', verb='pack')
        self.run_voxshell('pack', 'same-names.vdb', '--grid', 'mask[1]', '--snap')

    def test_exit_codes(self):
        for kind, code, pattern, *arguments in (
                ('fog', 5, 'fog volume'), ('vector', 5, 'grid of vec3s'), ('double', 5, 'grid of double'),
                ('unclassed', 1, 'name it with --grid'), ('stretched', 5, 'uniform scale'), ('frustum', 5, 'frustum'),
                ('nan', 3, r'holds nan at \(3, 1, 0\)'), ('nothing', 1, 'name it with'), ('huge-voxel', 4, 'voxel of 2000 m'),
                ('tiles-far-apart', 4, 'limit 1048576', '--grid', 'tile'),
                ('ball', 1, '--as is for masks', '--as', 'solid'), ('ball', 1, '--unit', '--unit', 'furlong'),
                ('ball', 1, '--as', '--as', 'jelly')):
            self.make(kind)
            with self.subTest(kind):
                self.refused(code, pattern, f'{kind}.vdb', *arguments, verb='pack')
        self.make('vector')
        odd = self.folder.joinpath('vector.vdb').read_bytes().replace(b'Tree_vec3s', b'Tree_vec9s')
        self.folder.joinpath('odd.vdb').write_bytes(odd)
        self.refused(5, 'Tree_vec9s', 'odd.vdb', verb='pack')
        self.refused(3, 'pack makes one of a level set', 'ball.vdb', '-o', 'x.csv', verb='export')

    @unittest.skipIf(command.sanitized(), 'a sanitizer has no limit of memory, and time for ten')
    def test_a_large_tile_costs_its_surface(self):
        self.make('mask-4096')  # a few hundred bytes
        self.refused(3, r'needs more than \d+ MiB', 'mask-4096.vdb', '--snap', '--as', 'surface', verb='pack')
        self.make('mask-1024')
        self.run_voxshell('pack', 'mask-1024.vdb', '--snap', out='6 279 176 surface, 1 067 462 648 interior')

    def test_ours_needs_no_help(self):
        self.make('ball')
        self.run_voxshell('pack', 'ball.vdb', '-q')
        self.run_voxshell('export', 'ball.voxmap', '-o', 'own.vdb')
        self.refused(1, r'grid `state` is voxshell\'s own', 'own.vdb', '--snap', '-o', 'x.voxmap', verb='pack')
        self.run_voxshell('pack', 'own.vdb', '--grid', 'state', '-o', 'x.voxmap', err='')

    def test_damage_leaves_nothing_behind(self):
        self.make('mask')
        whole = self.folder.joinpath('mask.vdb').read_bytes()
        chance = random.Random(17)
        refused = 0
        for trial in range(40):
            damaged = bytearray(whole)
            if trial % 2:
                for _ in range(1 + trial % 5):
                    damaged[chance.randrange(8, len(damaged))] ^= 1 << chance.randrange(8)
            else:
                del damaged[chance.randrange(len(damaged)):]
            self.folder.joinpath('damaged.vdb').write_bytes(damaged)
            before = self.listing()
            done = subprocess.run([command.BIN, 'pack', 'damaged.vdb', '--snap'], cwd=self.folder, capture_output=True, text=True, timeout=120)
            self.assertIn(done.returncode, (0, 1, 3, 4, 5), done.stderr)
            errors = [line for line in done.stderr.splitlines() if ': warning: ' not in line and not line.startswith('see ')]
            self.assertEqual(len(errors), 1 if done.returncode else 0, done.stderr)
            if done.returncode:
                self.assertEqual(self.listing(), before)
                refused += 1
            else:
                self.run_voxshell('verify', 'damaged.voxmap')
                self.folder.joinpath('damaged.voxmap').unlink()
        self.assertGreater(refused, 20)

    def test_an_interrupt_ends_the_reader_too(self):
        self.make('large')
        before = self.listing()
        for _ in range(20):
            parent = subprocess.Popen([command.BIN, 'pack', 'large.vdb', '-q'], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            children = pathlib.Path(f'/proc/{parent.pid}/task/{parent.pid}/children')
            child = None
            while parent.poll() is None and child is None:
                child = next(iter(children.read_text(encoding='ascii').split()), None)
            if child is not None:
                os.kill(int(child), signal.SIGSTOP)  # it will not finish now
                parent.send_signal(signal.SIGINT)
            out, err = parent.communicate(timeout=60)
            if parent.returncode == 0:
                self.folder.joinpath('large.voxmap').unlink()  # it was faster than we
                continue
            self.assertEqual((parent.returncode, out, err), (130, b'', b'voxshell pack: interrupted\n'))
            self.assertFalse(pathlib.Path(f'/proc/{child}').exists())
            self.assertEqual(self.listing(), before)
            return
        self.fail('never caught the reader at work')

    @unittest.skipUnless(shutil.which('vdb_tool') and shutil.which('vdb_print'), 'vdb_tool is not here (package libopenvdb-tools)')
    def test_openvdb_s_own_tools_at_both_ends(self):
        subprocess.run(['vdb_tool', '-sphere', 'dim=64', 'radius=0.5', 'name=ball', '-write', 'tool.vdb'], cwd=self.folder,
                       check=True, capture_output=True, timeout=120)
        self.run_voxshell('pack', 'tool.vdb', '--snap')
        found = self.inspect('tool.voxmap')
        self.run_voxshell('export', 'tool.voxmap', '-o', 'own.vdb')
        said = subprocess.run(['vdb_print', '-l', 'own.vdb'], cwd=self.folder, capture_output=True, text=True, timeout=60)
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertRegex(said.stdout, rf'Number of active voxels: +{found["surface_cells"] + found["interior_cells"]:,}\n')
        self.assertRegex(said.stdout, r'class: level set')
        # Our distances are a level set to OpenVDB: the mesh that it makes of them has the ball's size.
        subprocess.run(['vdb_tool', '-read', 'grids=distance', 'own.vdb', '-ls2mesh', '-write', 'mesh.obj'], cwd=self.folder,
                       check=True, capture_output=True, timeout=120)
        lines = self.folder.joinpath('mesh.obj').read_text(encoding='utf-8').splitlines()
        points = [tuple(map(float, line.split()[1:4])) for line in lines if line.startswith('v ')]
        half = found['voxel_m'] / 2  # snapped, and so is its centre
        radii = [sum((c - half) ** 2 for c in p) ** 0.5 for p in points]
        self.assertGreater(len(points), 1000)
        self.assertLess(max(radii) - 0.5, 0.05 * found['voxel_m'])
        self.assertLess(0.5 - min(radii), 0.05 * found['voxel_m'])


class Nano(command.CommandTest):
    def test_nvdb(self):
        subprocess.run([FOREIGN, 'ball', self.path('ball.vdb')], check=True, timeout=60)
        self.run_voxshell('pack', 'ball.vdb', '--snap', '-q')
        self.run_voxshell('export', 'ball.voxmap', '-o', 'a/ball.nvdb', err='', out=r'a/ball\.nvdb: [\d.]+ [KM]iB')
        whole = self.folder.joinpath('a/ball.nvdb').read_bytes()
        self.assertEqual(whole[:8], b'NanoVDB0')
        self.assertEqual(int.from_bytes(whole[12:14], 'little'), 2)  # grids: state, distance
        self.run_voxshell('export', 'ball.voxmap', '-o', 'b/ball.nvdb', '-j', '1', env={'MALLOC_PERTURB_': '85'})
        self.assertEqual(self.folder.joinpath('b/ball.nvdb').read_bytes(), whole)
        self.run_voxshell('export', 'ball.voxmap', '-o', 'own.vdb')
        self.run_voxshell('export', 'own.vdb', '-o', 'c/ball.nvdb')
        self.assertEqual(self.folder.joinpath('c/ball.nvdb').read_bytes(), whole)
        self.refused(1, r'vdb is exported as \.voxmap, \.nvdb', 'own.vdb', '-o', 'x.vdb', verb='export')


if __name__ == '__main__':
    command.main()
