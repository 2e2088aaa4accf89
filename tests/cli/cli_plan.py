# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene's plan: written beside its assets, the same bytes every time, the same run as the scene, and refused with other assets."""
import json
import pathlib
import shutil

import command
import schema
import shapes

SCENE = {
    'scene': 'voxshell-scene/1', 'voxel': '2mm', 'static': [{'file': 'cup.glb'}], 'dynamic': [{'file': 'ball.stl', 'unit': 'mm'}],
    'contact': {'law': 'average', 'stiffness': '50N/m'}, 'coupling': {'kind': 'pt2', 'frequency': '5Hz', 'damping': 1},
    'hand': {'path': [{'t': '0s', 'position': ['75mm', '40mm', '0mm']}, {'t': '0.3s', 'position': ['47mm', '40mm', '0mm']},
                      {'t': '0.6s', 'turn': {'about': ['0mm', '40mm', '0mm'], 'axis': [0, 1, 0], 'angle': '30deg'}}]}}


class Plan(command.CommandTest):
    def setUp(self):
        super().setUp()
        shapes.write_glb(self.path('cup.glb'), shapes.cup())
        shapes.write_stl(self.path('ball.stl'), shapes.sphere(12, rings=12))
        self.scene('press')

    def scene(self, name, **changes):
        pathlib.Path(self.path(f'{name}.scene.json')).write_text(json.dumps({**SCENE, **changes}), encoding='utf-8')

    def convert(self, name, folder, *more):
        self.run_voxshell('convert', f'{name}.scene.json', '-o', folder, '-q', *more)

    def trace(self, *arguments):
        self.run_voxshell('simulate', *arguments, '--trace', 'out.csv', '--force', '-q')
        return pathlib.Path(self.path('out.csv')).read_bytes()

    def test_runs_as_the_scene_does(self):
        for name, changes in {
            'press': {},
            'guarded': {'guards': [{'kind': 'start-inside'}, {'kind': 'slew', 'force': '1N/ms'}, {'kind': 'passivity'}]},
            'area': {'contact': {'law': 'patch', 'field': 'distance', 'weighting': 'area', 'stiffness': '1e8N/m^3', 'most_stiffness': '1000N/m'},
                     'coupling': {'design': 'auto', 'assume': 'hand'}, 'device': 'sim:omega-3', 'arm': 'pen', 'rate': '2kHz'},
            'spring': {'coupling': {'kind': 'spring-damper', 'stiffness': '1N/mm', 'mass': '50g', 'damping': 0.7}},
            'still': {'coupling': {'kind': 'quasi-static', 'stiffness': '1N/mm', 'evaluations': 2}, 'guards': []},
        }.items():
            with self.subTest(name):
                self.scene(name, **changes)
                self.convert(name, 'made')
                as_plan = self.trace(f'made/{name}.plan')
                self.assertGreater(len(as_plan.splitlines()), 500)
                self.assertEqual(as_plan, self.trace(f'{name}.scene.json'))
                self.assertEqual(as_plan, self.trace(f'{name}.scene.json', '--assets', 'made'))
                self.run_voxshell('verify', f'made/{name}.plan', out=f'^ok made/{name}.plan plan 1.0, .* 2 of 2 assets')

    def test_same_bytes(self):
        self.convert('press', 'one', '-j1')
        self.convert('press', 'many', '-j7')
        other = self.folder / 'some where'
        shutil.copytree(self.folder, other, ignore=shutil.ignore_patterns('some where', 'one', 'many'))
        self.run_voxshell('convert', other / 'press.scene.json', '-o', 'moved', '-q')
        first = self.digests(self.path('one'))
        self.assertIn('press.plan', str(first))
        self.assertEqual(first, self.digests(self.path('many')))
        self.assertEqual(first, self.digests(self.path('moved')))
        self.assertNotIn(str(self.folder).encode(), pathlib.Path(self.path('one', 'press.plan')).read_bytes())

    def test_other_assets(self):
        self.convert('press', 'a')
        self.scene('press', voxel='3mm')
        self.convert('press', 'b')
        told = json.loads(self.run_voxshell('inspect', 'a/press.voxmap', '--format', 'json').stdout)['content_hash']
        found = json.loads(self.run_voxshell('inspect', 'b/press.voxmap', '--format', 'json').stdout)['content_hash']
        both = rf'press\.plan: was made for press\.voxmap with content {told}, and this one has {found}; convert the scene again'
        self.refused(3, both, 'a/press.plan', '--assets', 'b', '-q', verb='simulate')
        self.trace('a/press.plan', '--assets', 'a')
        shutil.copy(self.path('b', 'press.pointshell'), self.path('a', 'press.pointshell'))
        self.refused(3, r'press\.plan: was made for press\.pointshell with content ', 'a/press.plan', '-q', verb='simulate')
        self.run_voxshell('verify', 'a/press.plan', code=3, err=r'was made for press\.pointshell with content ')
        pathlib.Path(self.path('a', 'press.pointshell')).unlink()
        self.refused(2, r'press\.pointshell: ', 'a/press.plan', '-q', verb='simulate')

    def test_refusals(self):
        self.convert('press', 'a')
        self.refused(1, r'press\.plan: --device: a plan is for its own device', 'a/press.plan', '--device', 'sim:omega-3', '-q', verb='simulate')
        self.refused(5, r'cup\.glb: a scene ends in \.scene\.json, a plan in \.plan', 'cup.glb', verb='simulate')
        golden = command.SOURCE / 'tests' / 'golden' / 'valid' / 'bare.plan'
        shutil.copy(golden, self.path('bare.plan'))
        self.refused(2, r'a\.voxmap: ', 'bare.plan', '-q', verb='simulate')
        self.run_voxshell('export', 'a/press.plan', '-o', 'x.csv', code=5, err=r'a plan has no cells and no points')
        self.refused(1, r'is a plan, ', 'a/press.voxmap', 'a/press.plan', verb='diff')

    def test_inspect_and_diff(self):
        self.convert('press', 'a')
        self.scene('press', guards=[{'kind': 'soft-start', 'time': '200ms'}], rate='500Hz')
        self.convert('press', 'b')
        said = json.loads(self.run_voxshell('inspect', 'b/press.plan', '--format', 'json').stdout)
        self.assertEqual(schema.problems(said, schema.load(command.SOURCE / 'formats' / 'schema' / 'inspect.schema.json')), [])
        self.assertEqual(said['effects'], [{'kind': 'soft-start', 'constants': [0.2]}])
        self.assertEqual([asset['name'] for asset in said['assets']], ['press.voxmap', 'press.pointshell'])
        done = self.run_voxshell('diff', 'a/press.plan', 'b/press.plan', code=6, out=r'rate: 1000 Hz / 500 Hz\n')
        self.assertIn('effect start-inside: 0: no constant / none\n', done.stdout)
        self.assertIn('effect soft-start: 1: time 0.5 s / 0: time 0.2 s\n', done.stdout)
        self.run_voxshell('diff', 'a/press.plan', 'a/press.plan', out='^equal\n$')


if __name__ == '__main__':
    command.main()
