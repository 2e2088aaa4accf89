# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell study paper: what study_page.py asks of every study, and which scenarios ran. One seed; twice with VXS_STUDY_TWICE=1."""
import os
import pathlib
import shutil
import subprocess

import browser
import command
import study_page


class Paper(study_page.StudyTest):
    ARGUMENTS = ('paper', '--quick', '--seeds', '1')
    COMMAND = 'voxshell study paper -o DIR --quick --seeds 1'
    TIMES = {'timing.csv'}

    def test_scenarios(self):
        ran = {row['scenario'] for name in ('runs.csv', 'loop_runs.csv') for row in self.csv[name]}
        self.assertEqual(ran, {f'fig8{c}' for c in 'abcd'} | {'fig9a', 'fig9b', 'degenerate-a', 'degenerate-b', 'control8', 'control9', 'control9-turned', 'wedge', 'peg', 'fig11', 'wall'}
                         | {f'fig12{c}' for c in 'abcd'})
        for row in self.csv['runs.csv']:
            if row['scenario'].startswith('degenerate'):
                self.assertEqual(row['degenerate'], '1')
            elif row['scenario'] not in ('peg', 'fig8a', 'fig8b'):
                self.assertEqual(row['degenerate'], '0', row)
        # What the runtime's own tests pin: the gradient of a trilinear distance has next to no force across a turned plane.
        smooth = [row for row in self.csv['control_means.csv'] if row['scenario'] == 'control8' and row['law'] == 'gradient']
        self.assertTrue(smooth and all(float(row['across_rms_pct']) < 0.5 and float(row['ripple_pct']) < 5 for row in smooth))
        for name in ('fig8', 'fig9'):
            for row in self.csv[f'{name}_means.csv']:
                if row['across_peak_pct']:
                    self.assertGreaterEqual(float(row['across_peak_pct']), float(row['across_rms_pct']))

    def test_points(self):
        """Figures 2 and 5: what is drawn of single points is what the runtime sums up, and the picture says what the paper's says."""
        naive, exact = self.csv['fig2_sums.csv']
        for row in (naive, exact):
            self.assertLess(float(row['off_pct']), 1e-9)
        self.assertGreater(int(exact['slice_pushing']), int(naive['slice_pushing']))
        self.assertLess(float(exact['across_ke']), float(naive['across_ke']))
        sizes = {panel: [float(row['dx_e']) ** 2 + float(row['dz_e']) ** 2 for row in self.csv['fig5.csv'] if row['panel'] == panel and row['kind'] == 'force'] for panel in 'bc'}
        spread = {panel: (max(found) / min(found)) ** 0.5 for panel, found in sizes.items()}
        self.assertGreater(spread['b'], 4)
        self.assertLess(spread['c'], 2.5)

    def test_quality(self):
        rows = {(row['benchmark'].split(',')[0], row['law'], row['field']): row for row in self.csv['quality.csv'] if row['shell'] == 'exact'}
        for benchmark in ('fig8', 'fig9'):
            self.assertLess(float(rows[benchmark, 'gradient', 'distance']['angle_mean_deg']), 0.1 * float(rows[benchmark, 'original', 'surface']['angle_mean_deg']))
        self.assertLess(float(rows['wedge', 'patch', 'distance']['angle_mean_deg']), 2)
        self.assertEqual(rows['peg of 20.2 mm', 'patch', 'distance']['angle_mean_deg'], '')

    def test_index(self):
        """The front page links the studies that are there, and shows what each says does not hold."""
        shutil.copytree(self.study, self.path('all', 'paper'))
        self.run_voxshell('study', 'index', '-o', 'all', out=r'index\.html')
        page = study_page.Page(pathlib.Path(self.path('all', 'index.html')).read_text())
        self.assertEqual((page.open, [link for link in page.links if link != 'data:,']), ([], ['paper/index.html']))
        self.assertEqual([alt for _, _, alt in page.sources], [self.told['figures'][0]['title']])
        for claim in self.told['claims']:
            self.assertEqual(claim['verdict'] != 'holds', claim['claim'] in page.text, claim['id'])
        program = browser.find()
        if program:
            with browser.Browser(program) as seen:
                seen.open(self.path('all', 'index.html'), *study_page.PHONE)
                self.assertGreater(seen.run('document.images[0].naturalWidth'), 100)
                self.assertEqual(seen.errors, [])
        self.refused(2, r'no study in its folders', 'index', '-o', 'nothing', verb='study')
        for text in ('{', '[]', '{"schema": "voxshell-study/2"}', '{"schema": "voxshell-study/1", "study": 5}'):
            pathlib.Path(self.path('all', 'paper', 'summary.json')).write_text(text)
            self.refused(3, r'summary\.json: ', 'index', '-o', 'all', '--force', verb='study')

    def test_interrupted_while_drawing(self):
        """A signal to the group ends gnuplot too, one to the program alone does not: both are an interruption, not gnuplot's failure."""
        fake = pathlib.Path(self.path('bin'), 'gnuplot')
        fake.parent.mkdir()
        for what in ('kill -TERM $$', 'kill -INT $PPID; exit 1'):
            fake.write_text(f'#!/bin/sh\n{what}\n')
            fake.chmod(0o755)
            done = subprocess.run([command.BIN, 'study', *self.ARGUMENTS, '-o', self.path('study')], capture_output=True, text=True, timeout=60,
                                  env={**os.environ, 'PATH': f'{fake.parent}:{os.environ["PATH"]}'})
            self.assertEqual((done.returncode, done.stdout, done.stderr), (130, '', 'voxshell study: interrupted\n'))
            self.assertFalse(os.path.exists(self.path('study')))

    def test_refusals(self):
        self.refused(1, r'KIND', verb='study')
        self.refused(1, r'papers', 'papers', '-o', 'study', verb='study')
        self.refused(1, r'--seeds', 'paper', '-o', 'study', '--seeds', '0', verb='study')
        self.refused(2, r'gnuplot is not installed', 'paper', '-o', 'study', verb='study', env={'PATH': '/nonexistent'})


if __name__ == '__main__':
    command.main()
