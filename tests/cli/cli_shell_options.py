# SPDX-License-Identifier: GPL-3.0-or-later
"""convert --shell-spacing, --thin-shell, --channels: what they change, what they say, and that nothing else changes."""
import csv
import math
import pathlib
import re
import struct

import command
import schema
import shapes

REPORT = schema.load(command.SOURCE / 'formats/schema/report.schema.json')


class ShellOptions(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.ball = shapes.write_stl(self.path('ball.stl'), shapes.sphere(10, rings=48))
        self.box = shapes.write_stl(self.path('box.stl'), shapes.box(20.1, 10.1, 20.1, at=(0.05, 0.05, 0.05)))

    def convert(self, part, folder, *options, **more):
        self.run_voxshell('convert', part, '-o', folder, '--voxel', '0.5mm', '--unit', 'mm', '--report', f'{folder}.json', '--reproducible',
                          *options, **more)
        report = self.load(f'{folder}.json')
        self.assertEqual(schema.problems(report, REPORT), [])
        return report

    def inspect(self, file):
        return command.json.loads(self.run_voxshell('inspect', file, '--format', 'json').stdout)

    def points(self, file):
        self.run_voxshell('export', file, '-o', file + '.ply')
        head, body = pathlib.Path(self.path(file + '.ply')).read_bytes().split(b'end_header\n', 1)
        count = int(re.search(rb'element vertex (\d+)', head)[1])
        return [struct.unpack_from('<7f', body, 28 * n) for n in range(count)]

    def test_spacing_changes_the_shell_alone(self):
        plain = self.convert(self.ball, 'p')
        before = self.digests(self.path('p'))
        fine = self.convert(self.ball, 'f', '--shell-spacing', '0.25mm', err='')
        after = self.digests(self.path('f'))
        self.assertEqual([n for n in before if before[n] != after[n]], ['ball.pointshell'])
        shell = self.inspect('f/ball.pointshell')
        self.assertEqual((shell['voxel_m'], fine['parts'][0]['shell_voxel_m'], fine['options']['shell_spacing_m']), (0.00025,) * 3)
        self.assertAlmostEqual(shell['points'] / plain['parts'][0]['points'], 4, delta=0.2)
        self.assertLessEqual(shell['gap_max_m'], 3 * 0.00025 * (1 + 1e-6))
        self.assertAlmostEqual(shell['gap_max_m'] / 0.00025, fine['parts'][0]['gap_max_h'], places=9)
        self.run_voxshell('inspect', 'f/ball.pointshell', out='"shell_spacing_m":0.00025')
        self.run_voxshell('verify', 'f')
        # The shell is the one that this voxel makes.
        self.run_voxshell('convert', self.ball, '-o', 'q', '--voxel', '0.25mm', '--unit', 'mm', '-q')
        self.assertEqual(self.points('q/ball.pointshell'), self.points('f/ball.pointshell'))
        # Its own voxel by name changes no point.
        self.convert(self.ball, 's', '--shell-spacing', '0.5mm', err='')
        self.assertEqual(self.points('s/ball.pointshell'), self.points('p/ball.pointshell'))

    def test_too_coarse_is_said_and_refused(self):
        report = self.convert(self.ball, 'c', '--shell-spacing', '2mm', err='warning.*more than three voxels of the map.*--shell-spacing 0.5 mm')
        self.assertEqual([w['code'] for w in report['warnings']], ['shell-too-coarse'])
        self.refused(4, r'more than three voxels.*\(--strict\)', self.ball, '-o', 'x', '--voxel', '0.5mm', '--unit', 'mm',
                     '--shell-spacing', '2mm', '--strict')
        self.refused(4, r'shell spacing 1 nm .* the smallest shell spacing that fits', self.ball, '-o', 'x', '--voxel', '0.5mm', '--unit',
                     'mm', '--shell-spacing', '1e-9m')

    def test_thinned(self):
        whole = self.convert(self.box, 'w')['parts'][0]
        thin = self.convert(self.box, 't', '--thin-shell', '2', err='', out='thinned from .* points, gap .* before; .* degrees')['parts'][0]
        cost = thin['thinning']
        self.assertEqual((cost['points_before'], cost['points'], cost['gap_before_h']), (whole['points'], thin['points'], whole['gap_max_h']))
        self.assertLess(thin['points'], 0.5 * whole['points'])
        self.assertLessEqual(cost['gap_max_h'], 3 * (1 + 1e-6))
        self.assertLessEqual(cost['distance_max_m'], 0.0005 * math.sqrt(12))
        self.assertLessEqual(cost['normal_max_deg'], 2.01)
        all_points, few = self.points('w/box.pointshell'), self.points('t/box.pointshell')
        self.assertLessEqual({p[:6] for p in few}, {p[:6] for p in all_points})
        self.assertAlmostEqual(sum(p[6] for p in few) / sum(p[6] for p in all_points), 1, delta=1e-6)
        self.run_voxshell('verify', 't')
        self.run_voxshell('verify', 't/box.pointshell', '--against', self.box, '--unit', 'mm')

    def test_channels(self):
        plain = self.convert(self.ball, 'p')
        self.assertFalse({'layers', 'distance_cells'} & set(plain['options']))
        both = self.convert(self.ball, 'b', '--channels', 'layers:3,distance:3', err='')
        self.assertEqual((both['options']['layers'], both['options']['distance_cells']), (3, 3))
        for file in 'b/ball.voxmap', 'b/ball.vdb':
            self.assertEqual(self.inspect(file)['channels'], ['layers', 'distance'])
        self.assertEqual(self.points('p/ball.pointshell'), self.points('b/ball.pointshell'))
        self.assertEqual(self.digests(self.path('p'))['ball.pointshell'], self.digests(self.path('b'))['ball.pointshell'])
        self.run_voxshell('verify', 'b')
        self.run_voxshell('export', 'b/ball.voxmap', '-o', 'cells.csv')
        with open(self.path('cells.csv'), newline='') as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(list(rows[0]), ['i', 'j', 'k', 'state', 'layer', 'distance_m'])
        bound = both['parts'][0]['distance_error_max_m'] + 10e-3 * (1 - math.cos(math.pi / 96) ** 2)  # and the facets
        near = 0
        for row in rows:
            centre = [0.0005 * (int(row[n]) + 0.5) for n in 'ijk']
            distance = math.dist(centre, (0, 0, 0)) - 0.010
            self.assertEqual(row['state'] == '1', row['layer'] == '0')
            if row['distance_m'] and abs(distance) < 0.0014:
                near += 1
                self.assertLessEqual(abs(float(row['distance_m']) - distance), bound)
        self.assertGreater(near, 10000)
        # Through .vdb and back, nothing is lost.
        self.run_voxshell('pack', 'b/ball.vdb', '-o', 'again.voxmap')
        self.run_voxshell('diff', 'b/ball.voxmap', 'again.voxmap')

    def test_a_band_of_many_bricks(self):
        """To the ball's centre, 20 cells, and 25 beyond it: measured against the mesh, through .vdb and back."""
        self.convert(self.ball, 'w', '--channels', 'distance:25', err='')
        for file in 'w/ball.voxmap', 'w/ball.vdb':
            self.run_voxshell('verify', file, '--against', self.ball, '--unit', 'mm')
        self.run_voxshell('export', 'w/ball.voxmap', '-o', 'wide.csv')
        with open(self.path('wide.csv'), newline='') as file:
            told = [float(row['distance_m']) for row in csv.DictReader(file) if row['state'] == '2' and row['distance_m']]
        self.assertAlmostEqual(min(told), -0.010, delta=0.0005)
        self.run_voxshell('pack', 'w/ball.vdb', '-o', 'wide.voxmap')
        self.run_voxshell('diff', 'w/ball.voxmap', 'wide.voxmap')

    def test_the_same_bytes_for_any_number_of_threads(self):
        for channels in 'distance:2.5', 'layers:2,distance:20':
            for threads in '1', '2':
                self.convert(self.ball, threads + channels, '-j', threads, '--shell-spacing', '0.3mm', '--thin-shell', '4', '--channels', channels)
            self.assertEqual(self.digests(self.path('1' + channels)), self.digests(self.path('2' + channels)))

    def test_what_is_refused(self):
        always = (self.ball, '-o', 'x', '--voxel', '0.5mm', '--unit', 'mm')
        for options, pattern in (
                (('--channels', 'layers'), 'layers:3'),
                (('--channels', 'layers:0'), '1 to 8'),
                (('--channels', 'layers:9'), '1 to 8'),
                (('--channels', 'layers:2.5'), 'not a number'),
                (('--channels', 'distance:64.5'), '1 to 64'),
                (('--channels', 'distance:nan'), 'not a number'),
                (('--channels', 'layers:3,layers:3'), 'twice'),
                (('--channels', 'layers:3,'), 'neither'),
                (('--channels', 'colour:3'), "'colour:3' is neither"),
                (('--shell-spacing', '2'), 'no unit'),
                (('--thin-shell', '0'), 'thin-shell'),
                (('--thin-shell', '31'), 'thin-shell'),
                (('--thin-shell', '5', '--shell', 'naive'), 'only for --shell exact')):
            self.refused(1, pattern, *always, *options)


if __name__ == '__main__':
    command.main()
