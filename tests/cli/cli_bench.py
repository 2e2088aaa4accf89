# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell bench: what it measures adds up, whatever the times are; simulate with a budget of microseconds."""
import json
import subprocess
import sys
import unittest

import command
import schema

BENCH = schema.load(command.SOURCE / 'formats/schema/bench.schema.json')


class Bench(command.CommandTest):
    def setUp(self):
        super().setUp()
        subprocess.run([sys.executable, command.SOURCE / 'samples/models/generate.py', self.folder], check=True)
        self.run_voxshell('convert', 'cup.glb', 'sphere.glb', '-o', '.', '--voxel', '1mm', '--channels', 'distance:3', '-q')

    def test_json(self):
        told = json.loads(self.run_voxshell('bench', 'cup.voxmap', 'sphere.pointshell', '--ticks', '200', '--format', 'json').stdout)
        self.assertEqual(schema.problems(told, BENCH), [])
        runs = {(r['motion'], r['field'], r['mode']): r for r in told['runs']}
        self.assertEqual(len(runs), 4 * 2 * 4)
        for (motion, field, mode), run in runs.items():
            self.assertEqual(run['ticks'], 200)
            self.assertLessEqual(run['p50_ns'], run['p99_ns'])
            self.assertLessEqual(run['p999_ns'], run['max_ns'])
            brute = runs[motion, field, 'scalar brute']
            self.assertEqual(run['points_in_contact'], brute['points_in_contact'])  # no mode changes the contact
            if 'brute' in mode:
                self.assertEqual(run['points_touched'], run['shell_points'])
            else:
                self.assertLess(run['points_touched'], 0.8 * run['shell_points'])
        self.assertEqual(runs['free', 'states', 'coherent']['points_in_contact'], 0)
        self.assertGreater(runs['sliding', 'states', 'coherent']['points_in_contact'], 10)
        self.assertGreater(told['points_in_1ms'][0]['worst_case'], 1000)

    def test_text(self):
        told = self.run_voxshell('bench', 'cup.voxmap', 'sphere.pointshell', '--ticks', '100').stdout
        self.assertIn('cup.voxmap x sphere.pointshell: 4 187 points', told)
        self.assertIn('in 1 ms:', told)

    def test_refusals(self):
        self.refused(1, 'give a .voxmap and a .pointshell', 'cup.voxmap', verb='bench')
        self.refused(1, 'voxshell pack', 'cup.vdb', 'sphere.pointshell', verb='bench')
        self.refused(2, 'none.voxmap', 'none.voxmap', 'sphere.pointshell', verb='bench')


class Budget(command.CommandTest):
    def simulate(self, contact):
        subprocess.run([sys.executable, command.SOURCE / 'samples/models/generate.py', self.folder], check=True)
        scene = json.loads((command.SOURCE / 'samples/scenes/cup_press.scene.json').read_text())
        scene['contact'] = contact
        (self.folder / 'press.scene.json').write_text(json.dumps(scene))

    def test_budget(self):
        area = {'law': 'gradient', 'weighting': 'area', 'stiffness': '1e7N/m^3'}
        self.simulate(area)
        free = json.loads(self.run_voxshell('simulate', 'press.scene.json', '--format', 'json').stdout)
        self.assertEqual((free['budget_points'], free['level_max']), (0, 0))
        self.simulate({**area, 'budget': '0.1us'})
        tight = json.loads(self.run_voxshell('simulate', 'press.scene.json', '--format', 'json').stdout)
        self.assertGreater(tight['budget_points'], 0)
        self.assertLessEqual(tight['probed_max'], max(tight['budget_points'], 17))  # one point a cluster at least
        self.assertLess(tight['probed_max'], free['probed_max'])
        self.assertGreater(tight['level_max'], 0)

    def test_only_with_area(self):
        self.simulate({'law': 'average', 'stiffness': '50N/m', 'budget': '20us'})
        self.refused(3, '/contact/budget', 'press.scene.json', verb='simulate')


if __name__ == '__main__':
    command.main()
