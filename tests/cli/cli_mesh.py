# SPDX-License-Identifier: GPL-3.0-or-later
"""convert: what it tells of a mesh, mends on request, and the voxel that it chooses."""
import math

import command
import schema
import shapes

REPORT = schema.load(command.SOURCE / 'formats/schema/report.schema.json')
ESTIMATE = schema.load(command.SOURCE / 'formats/schema/estimate.schema.json')


def torn(triangles, by):
    """Each triangle a little elsewhere: cracks along every edge."""
    return [tuple(tuple(x + by * math.sin(7 * n + 3 * k + axis) for axis, x in enumerate(p)) for k, p in enumerate(t))
            for n, t in enumerate(triangles)]


class Mesh(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.cup = shapes.write_stl(self.path('cup.stl'), shapes.cup(wall=3.0))

    def convert(self, file, *arguments, **more):
        done = self.run_voxshell('convert', file, '-o', 'out', '--unit', 'mm', '--force', '--report', 'r.json', *arguments, **more)
        if done.returncode == 0 and '--dry-run' not in arguments:
            report = self.load('r.json')
            self.assertEqual(schema.problems(report, REPORT), [])
            self.report, self.part, self.codes = report, report['parts'][0], [w['code'] for w in report['warnings']]
        return done

    def test_auto_gives_the_wall_three_voxels(self):
        self.convert(self.cup, '--voxel', 'auto', err='',
                     out=r'\n  voxel   1 mm: 99 % of the walls are at least 2\.99\d mm, three voxels each\n')
        self.assertEqual(self.report['options']['voxel_m'], 0.001)
        self.assertTrue(self.report['options']['voxel_auto'])
        self.assertEqual(self.part['voxel_m'], 0.001)
        walls = self.part['thickness']
        for key in ('q01_m', 'q05_m', 'q50_m', 'thinnest_m'):
            self.assertAlmostEqual(walls[key] / 0.003, 1, delta=0.02)
        self.assertEqual([b['share'] for b in walls['below'][:3]], [0, 0, 0])
        first = self.digests(self.path('out'))
        for threads in ('1', '3'):
            self.convert(self.cup, '--voxel', 'auto', '-j', threads)
            self.assertEqual(self.digests(self.path('out')), first)
        self.convert(self.cup, '--voxel', '1mm', '--strict')
        self.assertEqual(self.digests(self.path('out')), first)

    def test_auto_dry_run_foresees_the_same(self):
        self.convert(self.cup, '--voxel', 'auto', '--dry-run', out='voxel 1 mm: 99 % of the walls')
        done = self.convert(self.cup, '--voxel', 'auto', '--dry-run', '--format', 'json')
        estimate = command.json.loads(done.stdout)
        self.assertEqual(schema.problems(estimate, ESTIMATE), [])
        self.assertEqual(estimate['estimates'][0]['voxel_m'], 0.001)

    def test_auto_within_bounds(self):
        needle = shapes.write_stl(self.path('needle.stl'), shapes.box(100, 100, 0.01))
        self.convert(needle, '--voxel', 'auto', '--dry-run', out=r'voxel 50 um: .* 10 um, less than three voxels; but .* 2000 voxels')
        self.convert(self.cup, '--voxel', 'auto', '--max-memory', '59M', '--dry-run', out=r'1 mm would need more memory than 59\.0 MiB')
        sheet = shapes.write_stl(self.path('sheet.stl'), shapes.box(50, 50, 50)[:2])
        self.convert(sheet, '--voxel', 'auto', out=r'voxel   0\.1 mm: no interior that could be measured', err='open mesh')
        self.assertIsNone(self.part['thickness'])
        self.convert(self.cup, '--voxel', 'automatic', code=1, err="--voxel: 'automatic' is not a length")

    def test_several_parts_each_with_its_voxel(self):
        other = shapes.write_stl(self.path('other.stl'), shapes.box(50, 50, 6.5))
        self.convert(self.cup, other, '--voxel', 'auto')
        self.assertEqual([p['voxel_m'] for p in self.report['parts']], [0.001, 0.002])
        self.assertIsNone(self.report['options']['voxel_m'])

    def test_thin_walls_are_told_and_refused(self):
        self.convert(self.cup, '--voxel', '2mm', err=r'warning: .*88 % of the walls are thinner than three voxels.*--voxel 1mm would do')
        self.assertEqual(self.codes, ['thin-walls'])
        self.refused(4, r'thinner than three voxels.*--voxel 1mm would do \(--strict\)', self.cup, '-o', self.path('strict'),
                     '--unit', 'mm', '--voxel', '2mm', '--strict')

    def test_cracks_are_stitched_on_request(self):
        ball = shapes.sphere(10)
        cracked = shapes.write_stl(self.path('cracked.stl'), torn(ball, 1e-3))
        self.convert(cracked, '--voxel', '0.5mm', out='open')
        self.assertEqual((self.part['closed'], self.part['mesh']['boundary_edges'], self.part['mesh']['stitched']), (False, 3 * len(ball), 0))
        self.assertGreater(self.part['mesh']['open_edges_on_lattice'], 0)
        self.refused(4, 'open mesh', cracked, '-o', self.path('s'), '--unit', 'mm', '--voxel', '0.5mm', '--strict')
        self.convert(cracked, '--voxel', '0.5mm', '--weld', '10um', '--strict', err='', out=r'closed.*6 624 edges closed by moving \d[\d ]* vertices at most \d')
        mesh = self.part['mesh']
        self.assertEqual((self.part['closed'], mesh['boundary_edges'], mesh['stitched_edges']), (True, 0, 3 * len(ball)))
        self.assertLessEqual(mesh['stitched_max_m'], 1e-5)
        self.convert(cracked, '--voxel', '0.5mm', '--weld', '1mm', code=1, err='--weld: 1 mm would change the part itself')

    def test_cracks_below_the_lattice_are_no_holes(self):
        cracked = shapes.write_stl(self.path('cracked.stl'), torn(shapes.box(9.9, 9.9, 9.9, at=(0.1, 0.1, 0.1)), 1e-6))
        self.convert(cracked, '--voxel', '0.5mm', '--strict', err='warning: .*cracks: 36 boundary edges')
        self.assertIn('cracks', self.codes)
        self.assertNotIn('open-mesh', self.codes)
        self.assertEqual(self.part['mesh']['open_edges_on_lattice'], 0)
        self.assertGreater(self.part['interior_cells'], 5000)

    def test_each_defect_has_its_figure(self):
        box = shapes.box(10, 10, 10)
        self.convert(shapes.write_stl(self.path('twice.stl'), box + box[:1]), '--voxel', '0.5mm')
        self.assertEqual((self.part['mesh']['duplicate'], self.part['mesh']['non_manifold_edges']), (1, 3))
        self.convert(shapes.write_stl(self.path('turned.stl'), shapes.flipped(box[:1]) + box[1:]), '--voxel', '0.5mm')
        self.assertEqual((self.part['mesh']['badly_wound_edges'], self.part['mesh']['flipped'], self.part['mesh']['shells_flipped']), (3, 1, 0))
        self.convert(shapes.write_stl(self.path('two.stl'), box + shapes.box(10, 10, 10, at=(5, 5, 5))), '--voxel', '0.5mm')
        self.assertEqual((self.part['mesh']['shells'], self.codes), (2, ['self-intersecting']))
        self.assertGreaterEqual(self.part['mesh']['self_intersections'], 12)
        self.convert(self.cup, '--voxel', '0.5mm', err='', out=r'^[^\n]*\n  cells')  # nothing to say, no line
        self.assertEqual(self.part['mesh']['self_intersections'], 0)

    def test_large_parts_are_looked_at_on_request(self):
        ball = shapes.write_stl(self.path('ball.stl'), shapes.sphere(10, rings=80))
        self.convert(ball, '--voxel', '0.5mm', err='')
        self.assertIsNone(self.part['mesh']['self_intersections'])
        self.convert(ball, '--voxel', '0.5mm', '--inspect-mesh', out=r'  mesh    1 shells: 0 boundary edges.* 0 cut others\n  walls   99 % at least 19\.\d+ mm')
        self.assertEqual(self.part['mesh']['self_intersections'], 0)


if __name__ == '__main__':
    command.main()
