# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell convert and simulate of a scene: what they print, what they refuse, and the same trace on every run."""
import csv
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

import command
import schema

SIMULATE = schema.load(command.SOURCE / 'formats/schema/simulate.schema.json')
GENERATOR = command.SOURCE / 'samples/models/generate.py'


def steps(path):
    with open(path, newline='', encoding='utf-8') as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def force(row, name):
    return math.hypot(*(row[f'{name}_f{axis}_n'] for axis in 'xyz'))


class Simulate(command.CommandTest):
    def setUp(self):
        super().setUp()
        subprocess.run([sys.executable, GENERATOR, self.folder], check=True)
        for scene in ('cup_press', 'cup_slide', 'peg_in_hole'):
            shutil.copy(command.SOURCE / f'samples/scenes/{scene}.scene.json', self.folder)

    def edit(self, change, name='cup_press.scene.json'):
        path = self.folder / name
        scene = json.loads(path.read_text())
        change(scene)
        path.write_text(json.dumps(scene))

    def simulate(self, *arguments, **more):
        return self.run_voxshell('simulate', 'cup_press.scene.json', *arguments, **more)

    def test_press(self):
        self.run_voxshell('convert', 'cup_press.scene.json', '-o', 'assets', out='cup_press/static: .*cup_press/dynamic: ')
        self.assertEqual(self.listing(self.path('assets')),
                         ['cup_press.plan', 'cup_press.pointshell', 'cup_press.vdb', 'cup_press.voxmap'])
        self.simulate('--assets', 'assets', '--trace', 'a.csv', '--quiet', err='',
                      out=r'cup_press: 2\.28 s, 2 280 ticks at 1000 Hz on sim:phantom-premium-1\.5, held by a hand')
        rows = steps(self.path('a.csv'))
        self.assertEqual(len(rows), 2280)
        free = [row for row in rows if row['t_s'] < 0.65]
        self.assertTrue(all(force(row, 'output') == 0 == force(row, 'collision') for row in free))
        held = rows[-500:]  # at rest: what comes out is what goes in, and it holds the hand's spring
        self.assertGreater(force(held[0], 'output'), 0.5)
        for row in held:
            self.assertAlmostEqual(force(row, 'output'), force(row, 'collision'), delta=0.01)
            self.assertGreater(row['output_fx_n'], 0.99 * force(row, 'output'))
            self.assertAlmostEqual(500 * (row['device_x_m'] - row['hand_x_m']), row['output_fx_n'], delta=0.06)

    def test_peg_in_hole(self):
        """Goes in without a push, though its sides are opposed, and is held by the wall that the hand presses it to."""
        self.run_voxshell('simulate', 'peg_in_hole.scene.json', '--trace', 'a.csv', '--format', 'json', '--quiet')
        rows = steps(self.path('a.csv'))
        self.assertEqual(len(rows), 3600)
        went_in = [row for row in rows if 1.6 < row['t_s'] < 2.1]  # deep enough to touch at both ends
        self.assertGreater(sum(row['contacts'] > 0 for row in went_in), 400)
        self.assertLess(max(force(row, 'collision') for row in went_in), 0.04)
        for row in rows[-200:]:
            self.assertLess(row['collision_fx_n'], -0.3)
            self.assertLess(abs(row['collision_fy_n']) + abs(row['collision_fz_n']), 0.01)
            self.assertAlmostEqual(500 * (row['hand_x_m'] - row['device_x_m']), -row['output_fx_n'], delta=0.06)
        jumps = [abs(b['collision_fx_n'] - a['collision_fx_n']) for a, b in zip(rows, rows[1:])]
        self.assertLess(max(jumps), 0.06)  # an encoder's step of 30 um at 2 N/mm

    def test_same_trace_on_every_run(self):
        self.simulate('--trace', 'a.csv', '--quiet', '-j', 1)
        self.simulate('--trace', 'b.csv', '--quiet', '-j', 2)
        self.assertEqual(pathlib.Path(self.path('a.csv')).read_bytes(), pathlib.Path(self.path('b.csv')).read_bytes())

    def test_json(self):
        done = self.simulate('--format', 'json', '--explain', '--seconds', 1, '--device', 'sim:omega-3', '--quiet')
        told = json.loads(done.stdout)
        self.assertEqual(schema.problems(told, SIMULATE), [])
        self.assertEqual(told['device'], 'sim:omega-3')
        self.assertEqual(told['ticks'], 1000)
        self.assertEqual([stage['stage'] for stage in told['explain']], ['exchange', 'contact', 'coupling', 'tick'])
        self.assertEqual(set(told['flag_ticks']) - {'ramping', 'deep'}, set())
        effects = {effect['effect']: effect for effect in told['effects']}
        self.assertEqual({name for name, effect in effects.items() if effect['in']}, {'start-inside', 'soft-start'})  # no torque on this device
        for name, effect in effects.items():
            self.assertTrue(effect['reads'], name)
            self.assertEqual(effect['ns'] is None, effect['why_not'] != '', name)
            self.assertEqual(effect['instructions'] is None, effect['ns'] is None or told['not_counted'] != '', name)
        self.assertEqual([stage['stage'] for stage in told['stages']], ['contact', 'coupling', 'clamp', 'around'])
        if not told['not_counted']:
            # What is in and what is always there make up the tick; each effect has a price that is not nothing and not the world's.
            self.assertGreater(told['counted_ticks'], 1)
            parts = {part['stage']: part['instructions'] for part in told['explain']}
            self.assertTrue(all(count > 20 for count in parts.values()), parts)
            self.assertGreater(parts['tick'], parts['contact'])
            self.assertTrue(all(stage['instructions'] > 20 and stage['ns'] > 0 for stage in told['stages']), told['stages'])
            asked = sum(effect['instructions'] for effect in effects.values() if effect['in'])
            self.assertAlmostEqual(sum(stage['instructions'] for stage in told['stages']) + asked, parts['tick'], delta=1)
            for name, effect in effects.items():
                if effect['ns'] is not None:
                    self.assertTrue(10 < effect['instructions'] < 1e6, effect)
            # The same every time: they are counted, not measured. (Contact far from a surface and near it is not: so many ticks, the same ones.)
            again = json.loads(self.simulate('--format', 'json', '--explain', '--seconds', 1, '--device', 'sim:omega-3', '--quiet').stdout)
            for name in ('gravity', 'viscosity', 'slew', 'workspace'):
                other = next(effect for effect in again['effects'] if effect['effect'] == name)['instructions']
                self.assertAlmostEqual(effects[name]['instructions'] / other, 1, delta=0.005, msg=name)
        text = self.simulate('--explain', '--seconds', 0.2).stdout
        order = re.findall(r'^  (\S+) .* reads ', text, re.M)
        self.assertEqual(order[:7], ['contact', 'start-inside', 'torque', 'coupling', 'clamp', 'soft-start', 'around'])
        self.assertEqual(len(order), 4 + len(effects))

    def explain(self, scene, *arguments):
        return json.loads(self.run_voxshell('simulate', scene, '--explain', '--format', 'json', '--quiet', *arguments).stdout)

    @unittest.skipIf(command.counting(), 'instructions, with the counters in between')
    def test_effects_change_what_they_say(self):
        """An effect takes instructions in the stages that it names and in no other; what it names is not in vain."""
        told = self.explain('cup_press.scene.json')
        if told['not_counted']:
            self.skipTest(told['not_counted'])
        names = set()
        for effect in told['effects']:
            changes = {name for name in effect['changes'].split(', ') if name}
            self.assertLessEqual(set(effect['elsewhere']), changes, effect)
            if effect['ns'] is not None:
                names |= {effect['effect']} if changes and effect['elsewhere'] else set()
        self.assertEqual(names, {'friction', 'inertia', 'motion', 'torque'})

    def test_heavy_ticks(self):
        """A thousand points that touch: contact is stepped through once, and again where an effect changes it."""
        self.edit(lambda scene: scene.update(voxel='1mm'), 'peg_in_hole.scene.json')
        told = self.explain('peg_in_hole.scene.json', '--seconds', 2)
        if told['not_counted']:
            self.skipTest(told['not_counted'])
        self.assertEqual(told['counted_ticks'], 1)
        parts = {part['stage']: part['instructions'] for part in told['explain']}
        self.assertGreater(parts['contact'], 100_000)
        effects = {effect['effect']: effect for effect in told['effects']}
        for name in ('contact-damping', 'gravity', 'viscosity', 'slew', 'start-inside', 'soft-start', 'torque'):
            self.assertTrue(10 < effects[name]['instructions'] < 2000, effects[name])
            self.assertNotIn('contact', effects[name]['elsewhere'])
        self.assertGreater(effects['friction']['instructions'], 10_000)
        self.assertGreater(effects['friction']['elsewhere']['contact'], 5_000)

    def test_guards(self):
        """A loop that hums (count weighting, stiff): passivity calms it, and each list of guards does what it says."""
        def run(guards):
            def change(scene):
                scene['contact'] = {'law': 'average', 'weighting': 'count', 'stiffness': '500N/m'}
                scene.pop('guards', None)
                if guards is not None:
                    scene['guards'] = guards
            self.edit(change)
            told = json.loads(self.simulate('--trace', 'a.csv', '--force', '--explain', '--format', 'json', '--quiet').stdout)
            rows = steps(self.path('a.csv'))
            felt = [[row[f'output_f{axis}_n'] for axis in 'xyz'] for row in rows]
            self.assertAlmostEqual(told['step_max_n'], max(math.dist(a, b) for a, b in zip([[0, 0, 0], *felt], felt)), delta=1e-12)
            rows = rows[-300:]
            return told, max(row['device_x_m'] for row in rows) - min(row['device_x_m'] for row in rows)

        safe, hum = run(None)
        self.assertIn('ramping', safe['flag_ticks'])
        self.assertTrue(safe['explain'][-1]['what'].endswith(', start-inside, torque, soft-start: the whole of it'))
        self.assertEqual(safe['energy_min_j'], 0)
        bare, _ = run([])
        self.assertNotIn('ramping', bare['flag_ticks'])
        self.assertTrue(bare['explain'][-1]['what'].endswith(' N, torque: the whole of it'))
        calm, rest = run([{'kind': 'start-inside'}, {'kind': 'soft-start'}, {'kind': 'passivity'}])
        self.assertGreater(calm['flag_ticks']['damped'], 100)
        self.assertLess(calm['energy_min_j'], 0)
        print(f'swing of the last 0.3 s: {1e3 * hum:.3f} mm, with passivity {1e3 * rest:.3f} mm', file=sys.stderr)
        self.assertLess(rest, hum / 2)

    def test_realtime(self):
        told = json.loads(self.simulate('--realtime', '--seconds', 0.3, '--format', 'json', '--quiet').stdout)
        self.assertEqual(schema.problems(told, SIMULATE), [])
        self.assertGreater(told['ticks'], 0)
        self.assertIn('scheduling', told['realtime'])

    def test_pictures(self):
        self.refused(1, r'a\.pdf: a picture ends in \.svg or \.png', 'cup_press.scene.json', '--plot', 'a.pdf', verb='simulate')
        self.refused(2, r'gnuplot is not installed; apt-get install gnuplot-nox', 'cup_press.scene.json', '--plot', 'a.svg',
                     '--quiet', verb='simulate', env={'PATH': '/nonexistent'})
        if not shutil.which('gnuplot'):
            self.skipTest('gnuplot is not installed')
        self.simulate('--plot', 'a.svg', '--plot', 'a.png', '--quiet')
        self.assertIn('collision force', pathlib.Path(self.path('a.svg')).read_text())
        self.assertEqual(pathlib.Path(self.path('a.png')).read_bytes()[:4], b'\x89PNG')

    def test_assets_that_do_not_fit(self):
        self.run_voxshell('convert', 'cup_press.scene.json', '-o', 'assets')
        remedy = r'; run voxshell convert cup_press\.scene\.json -o assets --force'
        self.edit(lambda scene: scene.update(voxel='1mm'))
        self.refused(3, r'cup_press\.voxmap: has a voxel of 2 mm, the scene says 1 mm' + remedy, 'cup_press.scene.json',
                     '--assets', 'assets', verb='simulate')
        self.edit(lambda scene: scene.update(voxel='2mm', static=[{'file': 'cup.glb', 'pose': {'position': ['1mm', '0m', '0m']}}]))
        self.refused(3, r'was made from other files or poses than the scene has now' + remedy, 'cup_press.scene.json',
                     '--assets', 'assets', verb='simulate')
        self.refused(2, r'empty/cup_press\.voxmap: ', 'cup_press.scene.json', '--assets', 'empty', verb='simulate')

    def test_refusals(self):
        self.refused(1, r"no device 'sim:omni2'; there are sim:touch, ", 'cup_press.scene.json', '--device', 'sim:omni2',
                     '--quiet', verb='simulate')
        self.refused(5, r'cup\.glb: a scene ends in \.scene\.json', 'cup.glb', verb='simulate')
        self.refused(2, r'none\.scene\.json: cannot read', 'none.scene.json', verb='simulate')
        self.refused(1, '--seconds', 'cup_press.scene.json', '--seconds', '-1', verb='simulate')
        self.refused(1, r'--voxel and --up', 'cup_press.scene.json', '-o', 'x', '--voxel', '1mm')
        self.edit(lambda scene: scene.update(couplng=scene.pop('coupling')))
        self.refused(3, r'cup_press\.scene\.json: /couplng: unknown key; did you mean "coupling"\?', 'cup_press.scene.json',
                     verb='simulate')

    def test_stl_scene_equals_gltf_scene(self):
        """Millimetres in STL and metres in glTF are the same cup: cells and points to the last bit but rounding."""
        self.edit(lambda scene: scene.update(static=[{'file': 'cup.stl', 'unit': 'mm'}], dynamic=[{'file': 'sphere.stl', 'unit': 'mm'}]),
                  'cup_slide.scene.json')
        told = [json.loads(self.run_voxshell('simulate', f'{name}.scene.json', '--seconds', 2.2, '--format', 'json', '--quiet').stdout)
                for name in ('cup_press', 'cup_slide')]
        self.assertEqual(told[0]['shell_points'], told[1]['shell_points'])


if __name__ == '__main__':
    if not os.environ.get('VOXSHELL'):
        sys.exit('VOXSHELL names the program to test')
    command.main()
