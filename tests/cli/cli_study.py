# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell study paper: what study_page.py asks of every study, and which scenarios ran. One seed; twice with VXS_STUDY_TWICE=1."""
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

    def test_refusals(self):
        self.refused(1, r'KIND', verb='study')
        self.refused(1, r'papers', 'papers', '-o', 'study', verb='study')
        self.refused(1, r'--seeds', 'paper', '-o', 'study', '--seeds', '0', verb='study')
        self.refused(2, r'gnuplot is not installed', 'paper', '-o', 'study', verb='study', env={'PATH': '/nonexistent'})


if __name__ == '__main__':
    command.main()
