# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell design: its table, its JSON, its pictures, what it refuses; a scene whose coupling is designed."""
import csv
import json
import math
import pathlib
import shutil
import subprocess
import sys

import command
import schema

DESIGN = schema.load(command.SOURCE / 'formats/schema/design.schema.json')


class Design(command.CommandTest):
    def design(self, *arguments, code=0):
        told = json.loads(self.run_voxshell('design', *arguments, '--format', 'json', '--quiet', code=code).stdout)
        self.assertEqual(schema.problems(told, DESIGN), [])
        return told

    def scene(self, coupling, name='cup_press.scene.json', **contact):
        if not (self.folder / 'cup.glb').exists():
            subprocess.run([sys.executable, command.SOURCE / 'samples/models/generate.py', self.folder], check=True)
        scene = json.loads((command.SOURCE / 'samples/scenes/cup_press.scene.json').read_text())
        scene['coupling'] = coupling
        scene['contact'].update(contact)
        (self.folder / name).write_text(json.dumps(scene))
        return name

    def test_numbers(self):
        told = self.design('--frequency', '5Hz', '--stiffness', '100N/m', '--assume', 'hand')
        self.assertFalse(told['automatic'] or told['refused'])
        self.assertEqual((told['omega0_hz'], told['damping'], told['gain'], told['rate_hz']), (5, 1, 1, 1000))
        for arm, stiffness in (('free', 1.60), ('hand', 674)):  # published; the simulated substeps damp a little more
            self.assertAlmostEqual(told['k_max_n_per_m'][arm] / stiffness, 1, delta=0.01)
        self.assertAlmostEqual(told['margins']['gain_db'], 20 * math.log10(told['k_hunting_n_per_m']['hand'] / 100), places=6)
        slow = self.design('--device', 'sim:falcon', '--frequency', '0.68Hz', '--damping', 0.7071, '--stiffness', '2500N/m',
                           '--assume', 'hand', code=4)
        self.assertLess(slow['k_hunting_n_per_m']['hand'], 2500)
        self.assertGreater(slow['k_max_n_per_m']['hand'], 2500)
        self.assertEqual(told['passive'], {'free': False, 'pen': False, 'hand': False, 'arm': True})
        self.assertLess(told['margins_by_arm']['free']['gain_db'], 0)
        self.assertIsNone(told['margins_by_arm']['free']['delay_ms'])
        unfiltered = {row['omega0_hz']: row for row in told['k_max_by_filter']}[None]
        self.assertAlmostEqual(unfiltered['free'] / 66.7, 1, delta=0.03)
        self.assertTrue(any('no filter of this form is passive' in line for line in told['advice']))

        fast = self.design('--device', 'sim:omega-3', '--stiffness', '2N/mm', '--assume', 'hand')
        self.assertTrue(fast['automatic'] and fast['margins_held'])
        self.assertEqual(fast['rate_hz'], 4000)
        self.assertGreater(fast['bandwidth_hz'], 500)
        later = self.design('--device', 'sim:omega-3', '--stiffness', '2N/mm', '--assume', 'hand', '--delay', 8)
        self.assertLess(later['margins']['gain_db'], fast['margins']['gain_db'] - 6)
        spring = self.design('--coupling', 'quasi-static', '--stiffness', '1000N/mm')
        self.assertTrue(spring['margins_held'])
        self.assertLess(spring['seen_n_per_m'], spring['spring_n_per_m'])
        self.assertIsNone(self.design('--coupling', 'none', '--rate', '10kHz', '--assume', 'arm')['omega0_hz'])

    def test_refused(self):
        """Exit 4, with the whole answer before it."""
        told = self.design('--stiffness', '800N/m', code=4)
        self.assertTrue(told['refused'])
        self.run_voxshell('design', '--stiffness', '800N/m', code=4, out=r'unstable with the hand off: carries 51\.89 N/m.*passivity controller',
                          err=r'^voxshell design: error: unstable with an arm that counts; .*--assume hand')

    def test_usage(self):
        for pattern, *arguments in (
                (r"no device 'sim:omni2'; there are sim:touch", '--device', 'sim:omni2'),
                (r"--rate: '1000' is not a number above zero with a unit of Hz or kHz", '--rate', '1000'),
                (r'--rate must be between', '--rate', '1Hz'),
                (r"--stiffness: '-5N/m' is not", '--stiffness=-5N/m'),
                (r'--frequency is for --coupling pt2', '--coupling', 'none', '--frequency', '5Hz'),
                (r'--delay', '--delay', '0'),
                (r'--assume', '--assume', 'foot')):
            self.refused(1, pattern, *arguments, verb='design')
        self.refused(3, r'coupling: ', '--frequency', '700Hz', verb='design')
        self.refused(5, r'a scene ends in \.scene\.json', 'cup.glb', verb='design')

    def test_pictures(self):
        if not shutil.which('gnuplot'):
            self.skipTest('gnuplot is not installed')
        self.run_voxshell('design', '--frequency', '50Hz', '--stiffness', '400N/m', '--assume', 'hand', '-o', 'plots', '-q')
        self.assertEqual(self.listing(self.path('plots')), sorted(
            [f'{name}.{ending}' for name in ('bode', 'nyquist', 'impedance') for ending in ('csv', 'png', 'svg')] + ['design.json']))
        told = json.loads(pathlib.Path(self.path('plots', 'design.json')).read_text())
        self.assertEqual(schema.problems(told, DESIGN), [])
        for name in ('bode', 'nyquist', 'impedance'):
            svg = pathlib.Path(self.path('plots', f'{name}.svg')).read_text()
            self.assertIn('voxshell design --stiffness 400N/m --frequency 50Hz --damping 1 --assume hand -o DIR', svg)
            self.assertIn('phantom-premium-1.5, 1000 Hz, 400 N/m, PT2 50 Hz, d 1', svg)
        with open(self.path('plots', 'bode.csv'), newline='', encoding='utf-8') as file:
            rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
        # K_max is what the curve itself leaves where its phase first passes -180 degrees.
        for arm in ('free', 'pen', 'hand', 'arm'):
            crossing = next(row for row in rows if row[f'phase_{arm}_deg'] < -180)
            largest = told['contact_n_per_m'] * 10 ** (-crossing[f'gain_{arm}_db'] / 20)
            self.assertAlmostEqual(largest / told['k_max_n_per_m'][arm], 1, delta=0.05)
        with open(self.path('plots', 'impedance.csv'), newline='', encoding='utf-8') as file:
            rows = list(csv.DictReader(file))
        for arm in ('free', 'hand'):
            least = min(float(row[f'damping_{arm}_ns_per_m']) for row in rows)
            self.assertEqual(least >= 0, told['passive'][arm])
            self.assertAlmostEqual(max(-least, 0), told['damping_missing_ns_per_m'][arm], delta=0.01)
        self.refused(2, r'exists with other content; --force overwrites', '--stiffness', '300N/m', '--assume', 'hand', '-o', 'plots', '-q',
                     verb='design')

    def test_scene(self):
        """A scene's stiffness is what its path asks for, or what it bounds it to; it is refused for what design says."""
        auto = self.scene({'kind': 'pt2', 'design': 'auto'})
        told = self.design(auto, code=4)
        self.assertTrue(told['automatic'] and told['refused'])
        self.assertGreater(told['contact_n_per_m'], 1000)  # of 150 points of 50 N/m
        self.refused(4, rf"/coupling: no pt2 is stable on phantom-premium-1\.5 with the hand off: it carries .* contact has "
                     rf"{told['contact_n_per_m']:.4g} N/m \(all that the hand's path asks for at once", auto, '--quiet', verb='simulate')
        held = self.scene({'kind': 'pt2', 'design': 'auto', 'assume': 'hand'}, most_stiffness='800N/m')
        told = self.design(held)
        self.assertEqual((told['contact_n_per_m'], told['contact_source']), (800, "the scene's most_stiffness"))
        self.assertEqual(told['assume'], ['hand'])
        self.assertTrue(told['margins_held'])
        ran = json.loads(self.run_voxshell('simulate', held, '--format', 'json', '--quiet').stdout)
        self.assertEqual(ran['coupling'], f"pt2 {told['omega0_hz']:.4g} Hz (auto)")
        still = self.scene({'kind': 'quasi-static', 'design': 'auto'})
        told = self.design(still)
        ran = json.loads(self.run_voxshell('simulate', still, '--format', 'json', '--quiet').stdout)
        self.assertEqual(ran['coupling'], f"quasi-static {told['spring_n_per_m']:.4g} N/m (auto)")
        self.assertGreater(ran['contact_ticks'], 1000)
        self.assertNotIn('saturated', ran['flag_ticks'])
        # Without a kind the design picks it: contact that no pt2 carries, then contact that pt2 carries, but not within the wall of 6 mm.
        for contact, reason in (({}, 'no pt2 is stable'), ({'most_stiffness': '800N/m'}, 'with pt2 a push at 0.1 m/s into ')):
            free = self.scene({'design': 'auto', 'assume': 'hand'}, **contact)
            told = self.design(free)
            self.assertEqual((told['coupling'], told['automatic']), ('quasi-static', True))
            self.assertTrue(told['chosen'].startswith('quasi-static, since ' + reason), told['chosen'])
            self.assertEqual(told['push']['arm'], 'hand')
            self.assertAlmostEqual(told['push']['speed_m_per_s'], 0.1)
            self.assertAlmostEqual(told['push']['wall_m'], 0.006, delta=0.0023)  # to a cell, in steps of an eighth
            ran = json.loads(self.run_voxshell('simulate', free, '--format', 'json', '--quiet').stdout)
            self.assertEqual(ran['coupling'], f"quasi-static {told['spring_n_per_m']:.4g} N/m (auto)")
            self.run_voxshell('design', free, '--quiet', out=r'chosen    quasi-static, since .*\n  push      at 0\.1 m/s into ')
        self.assertIsNone(self.design(free, '--coupling', 'pt2')['chosen'])
        # The paper's 5 Hz is judged as it is; --auto picks in its place.
        paper = self.scene({'kind': 'pt2', 'frequency': '5Hz', 'damping': 1})
        self.assertFalse(self.design(paper, '--stiffness', '100N/m', '--assume', 'hand')['automatic'])
        self.assertTrue(self.design(paper, '--stiffness', '100N/m', '--assume', 'hand', '--auto')['automatic'])
        self.refused(1, r'the scene says the rate', paper, '--rate', '1kHz', verb='design')


if __name__ == '__main__':
    command.main()
