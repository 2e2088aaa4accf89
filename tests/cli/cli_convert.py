# SPDX-License-Identifier: GPL-3.0-or-later
"""convert: what it writes, what it says, what it refuses, and that it leaves nothing half done."""
import base64
import math
import os
import pathlib
import subprocess
import unittest

import command
import schema
import shapes

REPORT = schema.load(command.SOURCE / 'formats/schema/report.schema.json')
ESTIMATE = schema.load(command.SOURCE / 'formats/schema/estimate.schema.json')


class Convert(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.stl = shapes.write_stl(self.path('ball.stl'), shapes.sphere(10))
        self.glb = shapes.write_glb(self.path('cup.glb'), shapes.cup())

    def convert(self, *arguments, **more):
        return self.run_voxshell('convert', *arguments, **more)

    def test_outputs_and_summary(self):
        self.convert(self.stl, '-o', 'out/deep', '--voxel', '0.5mm', '--unit', 'mm', err='',
                     out=r'ball.*2 208 triangles, closed.*cells .* surface, .* interior of 0\.5 mm.*points .*wrote')
        self.assertEqual(self.listing(self.path('out')), ['deep', 'deep/ball.pointshell', 'deep/ball.vdb', 'deep/ball.voxmap'])

    def test_the_report_holds_and_is_right(self):
        done = self.convert(self.stl, self.glb, '-o', 'out', '--voxel', '0.5mm', '--unit', 'mm', '--format=json', '--report', 'r/report.json')
        report = self.load('r', 'report.json')
        self.assertEqual(schema.problems(report, REPORT), [])
        self.assertEqual([p['name'] for p in report['parts']], ['ball', 'cup'])
        ball = report['parts'][0]
        self.assertEqual((ball['triangles'], ball['degenerate'], ball['closed'], ball['oriented'], ball['leak']), (2208, 0, True, True, None))
        # A ball of 10 mm, 0.3 % smaller for its facets.
        self.assertAlmostEqual(ball['area_m2'] / (4 * math.pi * 1e-4), 1, delta=0.01)
        self.assertAlmostEqual(ball['volume_m3'] / (4 / 3 * math.pi * 1e-6), 1, delta=0.015)
        self.assertAlmostEqual(ball['surface_cells'] / (1.5 * ball['area_m2'] / 0.0005 ** 2), 1, delta=0.05)
        self.assertAlmostEqual((ball['interior_cells'] + ball['surface_cells'] / 2) * 0.0005 ** 3 / ball['volume_m3'], 1, delta=0.02)
        self.assertGreaterEqual(ball['points'], ball['surface_cells'])
        self.assertLessEqual(ball['gap_max_h'], 3)
        self.assertLess(ball['surface_error_max_m'], 0.0005 / 65536 * 1.8 + 1e-9)
        for output in report['outputs']:
            data = pathlib.Path(self.folder, output['path']).read_bytes()
            self.assertEqual((output['bytes'], output['sha256']), (len(data), command.hashlib.sha256(data).hexdigest()))
        self.assertEqual(report['inputs'][0]['sha256'], command.hashlib.sha256(pathlib.Path(self.stl).read_bytes()).hexdigest())
        self.assertEqual(schema.problems(command.json.loads(done.stdout), REPORT), [])

    @unittest.skipIf(command.sanitized(), 'memory under sanitizers is theirs')
    def test_a_file_is_held_once(self):
        """A cup and 96 MiB that nobody uses: the peak grows by the file's size, also where a .gltf embeds them."""
        def peak(name):
            # A program that is started counts the memory of the one that starts it: this one must be small.
            child = subprocess.Popen([command.BIN, 'convert', name, '-o', 'out', '--voxel', '2mm', '-q', '--force'], cwd=self.folder,
                                     stdout=subprocess.DEVNULL)
            _, status, usage = os.wait4(child.pid, 0)
            child.returncode = status
            self.assertEqual(status, 0, name)
            return usage.ru_maxrss * 1024

        plain = shapes.write_assembly(self.path('plain.gltf'), [(None, shapes.cup())], [{'mesh': 0}])
        document = self.load('plain.gltf')
        data = pathlib.Path(self.folder, document['buffers'][0]['uri']).read_bytes()
        size, piece, count = len(data), bytes(3 << 20), 32
        document['buffers'][0] = {'byteLength': size + count * len(piece), 'uri': 'DATA'}
        before, after = command.json.dumps(document).split('DATA')
        with open(self.path('beside.gltf'), 'w') as file:
            file.write(before + 'waste.bin' + after)
        with open(self.path('waste.bin'), 'wb') as file:
            file.write(data)
            for _ in range(count):
                file.write(piece)
        self.assertEqual(size % 3, 0, 'base64 is written piece by piece')
        with open(self.path('embedded.gltf'), 'w') as file:
            file.write(before + 'data:application/octet-stream;base64,' + base64.b64encode(data).decode())
            for _ in range(count):
                file.write(base64.b64encode(piece).decode())
            file.write(after)
        base = peak(plain)
        for name, held in (('beside.gltf', 'waste.bin'), ('embedded.gltf', 'embedded.gltf')):
            with self.subTest(name):
                self.assertLess(peak(name) - base, 1.1 * os.path.getsize(self.path(held)))

    def test_one_bad_part_does_not_stop_the_others(self):
        bad = self.path('bad.stl')
        with open(bad, 'wb') as file:
            file.write(b'\0' * 84 + b'short')
        done = self.convert(self.stl, bad, self.glb, '-o', 'out', '--voxel', '0.5mm', '--unit', 'mm', '--report', 'r.json', '--reproducible',
                            code=3, err=r'voxshell convert: error: \S*bad\.stl: ')
        report = self.load('r.json')
        self.assertEqual(schema.problems(report, REPORT), [])
        self.assertEqual([(f['path'], f['code']) for f in report['failed']], [('bad.stl', 3)])
        self.assertEqual([p['name'] for p in report['parts']], ['ball', 'cup'])
        self.assertEqual(len(self.listing(self.path('out'))), 6)
        self.assertEqual(done.stderr.count('error:'), 1)

    def test_naive_shell(self):
        self.convert(self.glb, '-o', 'out', '--voxel', '1mm', '--shell', 'naive')
        self.run_voxshell('inspect', 'out/cup.pointshell', out=' naive points')

    def test_up_turns_the_part(self):
        tall = shapes.write_stl(self.path('tall.stl'), shapes.box(4, 6, 30, at=(1, 2, 3)))
        for up, size in (('y', '4.* x 6.* x 30'), ('z', '4.* x 30.* x 6')):
            self.convert(tall, '-o', up, '--voxel', '0.5mm', '--unit', 'mm', '--up', up)
            self.run_voxshell('inspect', f'{up}/tall.pointshell', out=rf'^[^\n]*pointshell 1\.0, {size}\S* mm')

    def test_units(self):
        one = shapes.write_stl(self.path('one.stl'), shapes.box(1, 1, 1))
        for unit, voxel in (('mm', '62.5um'), ('cm', '0.625mm'), ('in', '0.0625in'), ('m', '6.25cm')):
            self.convert(one, '-o', unit, '--voxel', voxel, '--unit', unit, '-q')
        cells = [[row for row in self.run_voxshell('inspect', f'{unit}/one.voxmap').stdout.splitlines() if ' cells ' in row[:9]]
                 for unit in ('mm', 'cm', 'in', 'm')]
        self.assertEqual(cells.count(cells[0]), 4, cells)

    def test_equal_lengths_make_equal_bytes(self):
        for n, text in enumerate(('0.3mm', '3e-4m', '300um', '0.03cm', '0.0003m', '30e-2mm')):
            self.convert(self.glb, '-o', str(n), '--voxel', text, '-q')
            self.assertEqual(self.digests(self.path('0')), self.digests(self.path(str(n))), text)

    def test_missing_file_and_folder(self):
        self.refused(2, r'none\.glb: .*[Nn]o such file', self.path('none.glb'), '-o', self.path('out'), '--voxel', '1mm')
        self.folder.joinpath('dir.glb').mkdir()
        self.refused(2, r'dir\.glb: ', self.path('dir.glb'), '-o', self.path('out'), '--voxel', '1mm')

    def test_unwritable_folder(self):
        self.folder.joinpath('file').write_text('here\n')
        for folder in ('file', 'file/below'):
            self.refused(2, r'file: is not a folder', self.glb, '-o', self.path(folder), '--voxel', '1mm')
        self.refused(2, r'file: is not a folder', self.glb, '-o', self.path('out'), '--voxel', '1mm', '--report', self.path('file/r.json'))
        self.folder.joinpath('out').mkdir()
        self.folder.joinpath('out', 'cup.voxmap').mkdir()
        self.refused(2, r'cup\.voxmap: exists and is not a file', self.glb, '-o', self.path('out'), '--voxel', '1mm')

    def test_existing_outputs(self):
        self.convert(self.glb, '-o', 'out', '--voxel', '1mm')
        first = self.digests(self.path('out'))
        self.convert(self.glb, '-o', 'out', '--voxel', '1mm')  # the same again is no conflict
        self.refused(2, r'cup\.vdb: exists with other content; --force overwrites', self.glb, '-o', self.path('out'), '--voxel', '2mm')
        self.assertEqual(self.digests(self.path('out')), first)
        self.convert(self.glb, '-o', 'out', '--voxel', '2mm', '--force')
        self.assertNotEqual(self.digests(self.path('out')), first)

    def test_a_report_replaces_a_report_only(self):
        for _ in range(2):
            self.convert(self.glb, '-o', 'out', '--voxel', '1mm', '--report', 'r.json')
        self.folder.joinpath('letter.txt').write_text('dear\n')
        self.convert(self.glb, '-o', 'out', '--voxel', '1mm', '--report', 'letter.txt', code=2, err=r'letter\.txt: exists')
        self.assertEqual(self.folder.joinpath('letter.txt').read_text(), 'dear\n')

    def test_dry_run_writes_nothing(self):
        before = self.listing()
        self.convert(self.glb, '-o', 'out', '--voxel', '0.5mm', '--dry-run', '--report', 'r.json',
                     out=r'^cup.*384 triangles, about .* surface cells, .* of memory, .* of files, .* s\n$', err='')
        done = self.convert(self.glb, '-o', 'out', '--voxel', '0.5mm', '--dry-run', '--format', 'json', err='')
        self.assertEqual(self.listing(), before)
        estimate = command.json.loads(done.stdout)
        self.assertEqual(schema.problems(estimate, ESTIMATE), [])
        self.convert(self.glb, '-o', 'out', '--voxel', '0.5mm', '--report', 'r.json')
        part, foreseen = self.load('r.json')['parts'][0], estimate['estimates'][0]
        self.assertAlmostEqual(foreseen['surface_cells'] / part['surface_cells'], 1, delta=0.1)
        size = sum(output['bytes'] for output in self.load('r.json')['outputs'])
        self.assertTrue(0.5 < foreseen['file_bytes'] / size < 2, (foreseen, size))
        if not command.sanitized():
            self.assertGreater(foreseen['memory_bytes'], self.load('r.json')['cost']['peak_rss_bytes'] / 2)

    def test_too_large_is_refused_at_once(self):
        for arguments, pattern in ((['--voxel', '1um'], r'needs about .* the smallest voxel that fits is [\d.]+ (um|mm)$'),
                                   (['--voxel', '1e-12m'], r'smallest voxel'),
                                   (['--voxel', '0.05mm', '--max-memory', '64M'], r'0\.1 GiB are allowed.*smallest voxel that fits')):
            for dry in ([], ['--dry-run']):
                self.refused(4, pattern, self.glb, '-o', self.path('out'), *arguments, *dry, timeout=10)

    def test_the_voxel_that_fits_fits(self):
        text = self.refused(4, 'fits is', self.glb, '-o', self.path('out'), '--voxel', '0.01mm', '--max-memory', '100M').stderr
        voxel = ''.join(text.split('fits is ')[1].split())
        self.convert(self.glb, '-o', 'out', '--voxel', voxel, '--max-memory', '100M', '--dry-run')

    def test_open_mesh(self):
        sheet = shapes.write_stl(self.path('sheet.stl'), shapes.box()[:2])
        self.convert(sheet, '-o', 'out', '--voxel', '1mm', '--unit', 'mm', '--report', 'r.json',
                     out='open', err=r'^voxshell convert: warning: \S*sheet\.stl: open mesh: 4 boundary edges')
        report = self.load('r.json')
        self.assertEqual([w['code'] for w in report['warnings']], ['open-mesh'])
        self.assertEqual((report['parts'][0]['closed'], report['parts'][0]['interior_cells']), (False, 0))
        self.convert(sheet, '-o', 'out', '--voxel', '1mm', '--unit', 'mm', '-q', err='')
        self.refused(4, r'open mesh: 4 boundary edges.*--strict', sheet, '-o', self.path('strict'), '--voxel', '1mm', '--unit', 'mm', '--strict')

    def test_leak(self):
        hole = shapes.write_stl(self.path('hole.stl'), shapes.sphere(10)[60:])
        self.convert(hole, '-o', 'out', '--voxel', '0.5mm', '--unit', 'mm', '--report', 'r.json', err='warning: .*leaks')
        report = self.load('r.json')
        self.assertEqual(schema.problems(report, REPORT), [])
        self.assertIn('leak', [w['code'] for w in report['warnings']])
        leak = report['parts'][0]['leak']
        self.assertLess(math.dist(leak['at_m'], (0, 0, 0)), 0.01)
        self.assertGreaterEqual(abs(leak['winding']), 0.5)
        self.convert(hole, '-o', 'closed', '--voxel', '0.5mm', '--unit', 'mm', '--report', 'r.json', '--close-gaps', '6mm')
        self.assertGreater(self.load('r.json')['parts'][0]['interior_cells'], 25000)

    def test_inside_out(self):
        inverted = shapes.write_stl(self.path('inverted.stl'), shapes.flipped(shapes.sphere(10)))
        self.convert(inverted, '-o', 'a', '--voxel', '0.5mm', '--unit', 'mm', '--report', 'r.json', err='warning: .*turned outwards')
        self.assertEqual([w['code'] for w in self.load('r.json')['warnings']], ['flipped-shells'])
        self.assertGreater(self.load('r.json')['parts'][0]['volume_m3'], 0)
        self.refused(4, 'turned outwards.*--strict', inverted, '-o', self.path('b'), '--voxel', '0.5mm', '--unit', 'mm', '--strict')
        self.convert(self.stl, '-o', 'c', '--voxel', '0.5mm', '--unit', 'mm', '--strict')
        self.run_voxshell('diff', 'a/inverted.voxmap', 'c/ball.voxmap', out='^0 cells changed')

    def test_progress(self):
        done = self.convert(self.glb, '-o', 'a', '--voxel', '0.5mm', '--progress', 'json')
        for line in done.stderr.splitlines():
            self.assertEqual(sorted(command.json.loads(line)), ['done', 'stage', 'total'])
        self.assertGreater(len(done.stderr.splitlines()), 3)
        self.convert(self.glb, '-o', 'b', '--voxel', '0.5mm', '--progress', 'always', err=r'\[=* *\]')
        self.convert(self.glb, '-o', 'c', '--voxel', '0.5mm', '--progress', 'never', err='')
        self.convert(self.glb, '-o', 'd', '--voxel', '0.5mm', err='')  # stderr is no terminal

    def test_standard_output_full(self):
        with open('/dev/full', 'w', encoding='ascii') as full:
            done = subprocess.run([command.BIN, 'convert', self.glb, '-o', self.path('out'), '--voxel', '1mm'], stdout=full,
                                  stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, 'error: standard output: No space left')

    def test_disk_full(self):
        mount = self.path('small')
        os.mkdir(mount)
        if os.geteuid() != 0 or subprocess.run(['mount', '-t', 'tmpfs', '-o', 'size=256k', 'tmpfs', mount], stderr=subprocess.DEVNULL,
                                               check=False).returncode:
            self.skipTest('no small file system can be mounted here')
        self.addCleanup(subprocess.run, ['umount', mount], check=False)
        self.refused(2, r'cup\.\w+: No space left on device', self.glb, '-o', os.path.join(mount, 'out'), '--voxel', '0.5mm')
        self.assertEqual(os.listdir(mount), [])


if __name__ == '__main__':
    command.main()
