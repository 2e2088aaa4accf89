# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell study stability: what study_page.py asks of every study; foretold and found agree, and what is foretold calm, or passive, is.
Twice with VXS_STUDY_TWICE=1."""
import pathlib

import command
import study_page

MAP = command.SOURCE / 'tests/hard/map.csv'
ARMS = {'free', 'pen', 'hand', 'arm'}


class Stability(study_page.StudyTest):
    ARGUMENTS = ('stability', '--quick', '--hard-map', MAP)
    COMMAND = 'voxshell study stability -o DIR --quick --hard-map map.csv'
    TABLES = 6

    def test_map(self):
        loops = self.csv['loops.csv']
        self.assertEqual({row['arm'] for row in loops}, ARMS)
        self.assertEqual(len(loops), len({row['device'] for row in loops}) * len(ARMS) * len({row['filter'] for row in loops}))
        for row in loops:
            self.assertLess(abs(float(row['found_over_k_max']) - 1), 0.02, row)
            self.assertLessEqual(float(row['hunting_n_per_m']), float(row['k_max_n_per_m']))
            self.assertLess(float(row['passive_n_per_m']), float(row['k_max_n_per_m']))
            # The margin ends where the loop does.
            calm = float(row['recommended_n_per_m']) < float(row['k_max_n_per_m'])
            self.assertEqual(calm, float(row['gain_margin_db']) > 0, row)
            self.assertEqual(calm, row['delay_margin_ms'] != '' or row['phase_margin_deg'] == '', row)
        known = {(row['device'], row['arm'], row['filter']): float(row['k_max_n_per_m']) for row in loops}
        # DEVICES D, with the damping that the device's sixteen substeps add.
        for arm, wanted in (('free', {'none': 66.7, 'PT2 5 Hz': 1.6}), ('hand', {'none': 3424, 'PT2 5 Hz': 674, 'PT2 20 Hz': 432})):
            for coupling, stiffness in wanted.items():
                self.assertLess(abs(known['phantom-premium-1.5', arm, coupling] / stiffness - 1), 0.03)

    def test_cells(self):
        everything = self.csv['agreement.csv'][0]
        self.assertEqual(everything['device'], 'all')
        self.assertGreater(int(everything['unstable_cells']), 100)
        self.assertEqual(everything['passive_swinging'], '0')
        swinging = sum(float(row['amplitude_mm']) > 0 for name, rows in self.csv.items() if name.startswith('swing_') for row in rows)
        cells = sum(len(rows) for name, rows in self.csv.items() if name.startswith('swing_'))
        self.assertEqual(cells, sum(int(everything[key]) for key in ('calm_cells', 'hunting_cells', 'unstable_cells')))
        self.assertEqual(swinging, int(everything['calm_swinging']) + int(everything['hunting_swinging']) + int(everything['unstable_cells']) - int(everything['unstable_still']))

    def test_quasi_static(self):
        """The spring ends its stability, not the contact: where K_max says, and with what design takes nothing swings."""
        rows = self.csv['springs.csv']
        self.assertEqual(len(rows), len({row['device'] for row in rows}) * len(ARMS))
        for row in rows:
            self.assertLess(abs(float(row['found_over_foretold']) - 1), 0.05, row)
            self.assertLess(float(row['designed_n_per_m']), float(row['k_max_n_per_m']))
            self.assertEqual(row['swinging'], '0', row)

    def test_contact(self):
        for row in self.csv['contact_onset.csv']:
            ratio = float(row['found_over_k_max'])
            self.assertTrue(0.95 < ratio < (1.05 if row['body'] == 'flat' else 2.5), row)

    def test_hard_map(self):
        given = MAP.read_text().splitlines()
        self.assertEqual(len(self.csv['hard_cases.csv']), len(given) - 1)
        for row in self.csv['hard_totals.csv']:
            self.assertEqual(int(row['cases']), sum(int(row[key]) for key in ('holds', 'beyond', 'refused', 'fails')))

    def test_readme_picture(self):
        self.picture_is('swing_phantom-premium-1.5')

    def test_refusals(self):
        self.refused(2, r'none\.csv: cannot be read', 'stability', '-o', 'study', '--hard-map', 'none.csv', verb='study')
        head = 'case,worst,bound,pair,value,verdict\n'
        for text, said in (('', r'line 1'), ('a,b\n', r'line 1'), (head, 'no case'), (head + 'a,b,1,c,2\n', r'line 2: 5 fields'),
                           (head + 'a,b,1,c,two,holds\n', r"line 2: 'two' is no number"), (head + 'a,b,1,c,2,perhaps\n', r"line 2: verdict 'perhaps'")):
            pathlib.Path(self.path('map.csv')).write_text(text)
            self.refused(3, said, 'stability', '-o', 'study', '--hard-map', 'map.csv', verb='study')


if __name__ == '__main__':
    command.main()
