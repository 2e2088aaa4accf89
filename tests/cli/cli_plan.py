# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene's plan: written beside its assets, the same bytes every time, the same run as the scene, and refused with other assets."""
import json
import pathlib
import re
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
            'moving': {'static': [{'file': 'cup.glb'}, {'file': 'ball.stl', 'unit': 'mm', 'path': [
                {'t': '0s', 'position': ['120mm', '40mm', '0mm']}, {'t': '0.3s', 'position': ['90mm', '40mm', '0mm'], 'rotation': [0, 1, 0, 1]}]}]},
            'still': {'coupling': {'kind': 'quasi-static', 'stiffness': '1N/mm', 'evaluations': 2}, 'guards': []},
        }.items():
            with self.subTest(name):
                self.scene(name, **changes)
                self.convert(name, 'made')
                as_plan = self.trace(f'made/{name}.plan')
                self.assertGreater(len(as_plan.splitlines()), 500)
                self.assertEqual(as_plan, self.trace(f'{name}.scene.json'))
                self.assertEqual(as_plan, self.trace(f'{name}.scene.json', '--assets', 'made'))
                self.run_voxshell('verify', f'made/{name}.plan', out=f'^ok made/{name}.plan plan 1.0, .* (2 of 2|3 of 3) assets')

    def test_a_static_that_moves(self):
        """A ball comes to a hand that rests far from the cup: nothing, then contact as the ball's path says."""
        path = [{'t': '0s', 'position': ['160mm', '40mm', '0mm']}, {'t': '0.5s', 'position': ['120mm', '40mm', '0mm']}]
        ball = {'file': 'ball.stl', 'unit': 'mm', 'path': path}
        self.scene('press', static=[{'file': 'cup.glb'}, ball], hand={'path': [{'t': '0s', 'position': ['100mm', '40mm', '0mm']}]}, guards=[])
        self.convert('press', 'a')
        self.assertEqual(self.listing(self.path('a')), ['press.moving1.voxmap', 'press.plan', 'press.pointshell', 'press.vdb', 'press.voxmap'])
        said = json.loads(self.run_voxshell('inspect', 'a/press.plan', '--format', 'json').stdout)
        self.assertEqual([asset['name'] for asset in said['assets']], ['press.voxmap', 'press.moving1.voxmap', 'press.pointshell'])
        self.assertEqual((said['motion_keyframes'], said['effects']), (2, [{'kind': 'motion', 'constants': [0.0]}, {'kind': 'torque', 'constants': []}]))
        rows = self.trace('a/press.plan', '--seconds', '0.6').decode().splitlines()
        column = rows[0].split(',').index('contacts')
        contacts = [int(row.split(',')[column]) for row in rows[1:]]
        # Two balls of 12 mm touch when 24 mm apart: at x = 124 mm, 0.45 s; cells of 2 mm see it up to two cells earlier.
        first = next(n for n, count in enumerate(contacts) if count)
        self.assertLess(abs(first - 430), 40)
        self.refused(3, r'/static: at least one part must stand', *self.changed(static=[ball]))
        self.refused(3, r'/static: /effects/0 asks for motion, and no part says where it goes: give one a "path"', *self.changed(effects=[{'kind': 'motion'}]))
        self.refused(3, r'/static/1/path: says itself where the part is',
                     *self.changed(static=[{'file': 'cup.glb'}, {**ball, 'pose': {'position': ['0m', '0m', '0m']}}]))

    def changed(self, **changes):
        self.scene('other', **changes)
        return 'other.scene.json', '-o', 'other', '-q'

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
        self.refused(5, r'cup\.glb: a scene ends in \.scene\.json, \.scene\.gltf or \.scene\.glb, a plan in \.plan', 'cup.glb', verb='simulate')
        golden = command.SOURCE / 'tests' / 'golden' / 'valid' / 'bare.plan'
        shutil.copy(golden, self.path('bare.plan'))
        self.refused(2, r'a\.voxmap: ', 'bare.plan', '-q', verb='simulate')
        self.run_voxshell('export', 'a/press.plan', '-o', 'x.csv', code=5, err=r'a plan has no cells and no points')
        self.refused(1, r'is a plan, ', 'a/press.voxmap', 'a/press.plan', verb='diff')

    def test_nothing_unasked(self):
        """An effect that reads nothing of the assets leaves their bytes as they are; one that needs a channel has it."""
        self.convert('press', 'bare')
        bare = self.digests(self.path('bare'))
        assets = {name: digest for name, digest in bare.items() if not name.endswith('.plan')}
        self.assertEqual(len(assets), 3)
        ball = {'file': 'ball.stl', 'unit': 'mm'}
        path = [{'t': '0s', 'position': ['160mm', '40mm', '0mm']}, {'t': '0.5s', 'position': ['120mm', '40mm', '0mm']}]
        alone = {kind: {'effects': [{'kind': kind}]} for kind in ('viscosity', 'gravity', 'friction', 'contact-damping', 'workspace')}
        alone |= {kind: {'guards': [{'kind': kind}]} for kind in ('start-inside', 'soft-start', 'passivity')}
        alone['slew'] = {'guards': [{'kind': 'slew', 'force': '1N/ms'}]}
        alone['torque'] = {'device': 'sim:omega-3'}  # which has none, and so the plan
        alone['inertia'] = {'dynamic': [{**ball, 'density': '1g/cm^3'}], 'effects': [{'kind': 'inertia'}], 'coupling': {'kind': 'none'}}
        alone['motion'] = {'static': [{'file': 'cup.glb'}, {**ball, 'path': path}]}  # and one more map, of what moves
        for kind, changes in alone.items():
            self.scene('press', **changes)
            self.convert('press', kind)
            with_effect = self.digests(self.path(kind))
            self.assertEqual({**with_effect, **assets}, with_effect, kind)
            self.assertEqual(len(with_effect), len(bare) + (kind == 'motion'))
            self.assertNotEqual(with_effect['press.plan'], bare['press.plan'])
            self.assertEqual(self.trace(f'{kind}/press.plan'), self.trace('press.scene.json'))
        self.scene('press', effects=[{'kind': 'proximity', 'reach': '5mm'}])
        self.convert('press', 'near')
        near = self.digests(self.path('near'))
        self.assertEqual(near['press.pointshell'], bare['press.pointshell'])
        channels = lambda folder: json.loads(self.run_voxshell('inspect', f'{folder}/press.voxmap', '--format', 'json').stdout)['channels']
        self.assertEqual((channels('bare'), channels('near')), ([], ['distance']))
        self.trace('near/press.plan')
        # Areas are there for the weighting that reads them, and are all that differs; a part by itself has them.
        self.scene('press', contact={'law': 'average', 'weighting': 'area', 'stiffness': '1e8N/m^3'})
        self.convert('press', 'area')
        facts = lambda path: json.loads(self.run_voxshell('inspect', path, '--format', 'json').stdout)
        with_areas, without = facts('area/press.pointshell'), facts('bare/press.pointshell')
        self.assertEqual((with_areas['areas'], without['areas']), (True, False))
        self.assertEqual(with_areas['area_m2'], without['area_m2'])
        points = without['points']
        more = with_areas['bytes'] - without['bytes'] - 4 * ((points + 15) // 16 * 16)
        self.assertIn(more, (0, 64))  # the line in the table
        for name in ('press.voxmap', 'press.vdb'):
            self.assertEqual(self.digests(self.path('area'))[name], bare[name])
        self.run_voxshell('diff', 'area/press.pointshell', 'bare/press.pointshell', code=6, out=r'areas of points: stored / none\n0 points changed')
        self.run_voxshell('convert', 'ball.stl', '--unit', 'mm', '--voxel', '2mm', '-o', 'part', '-q')
        self.assertTrue(facts('part/ball.pointshell')['areas'])
        for name in ('bare', 'area'):
            self.run_voxshell('export', f'{name}/press.pointshell', '-o', f'{name}.csv')
            self.run_voxshell('verify', f'{name}/press.pointshell', '--against', 'press.scene.json')
        heads = [pathlib.Path(self.path(f'{name}.csv')).read_text().splitlines() for name in ('bare', 'area')]
        self.assertEqual([h[0] for h in heads], ['x,y,z,nx,ny,nz', 'x,y,z,nx,ny,nz,area'])
        self.assertEqual(heads[0][1:], [line.rsplit(',', 1)[0] for line in heads[1][1:]])
        for ending, size in (('ply', 4), ('glb', 4)):
            for name in ('bare', 'area'):
                self.run_voxshell('export', f'{name}/press.pointshell', '-o', f'{name}.{ending}')
            more = pathlib.Path(self.path(f'area.{ending}')).stat().st_size - pathlib.Path(self.path(f'bare.{ending}')).stat().st_size
            self.assertGreaterEqual(more, size * points)
        # Assets of the other scene do not serve: what weighs by area says so.
        self.refused(3, r'contact: the shell has no areas, by which to weigh points', 'press.scene.json', '--assets', 'bare', '-q', verb='simulate')
        self.scene('press', effects=[{'kind': 'proximity', 'reach': '1m'}])
        self.refused(3, r'/effects: one looks 1 m far into the distances around a surface, and they reach 64 voxels: 0\.128 m', 'press.scene.json', '-o', 'far', '-q')
        self.scene('press', effects=[{'kind': 'proximity', 'reach': '5mm'}])
        done = self.run_voxshell('convert', 'press.scene.json', '-o', 'told', '--explain')
        self.assertRegex(done.stdout, r'DIST +[\d ]+ bytes  an effect that looks 5 mm far')
        self.assertRegex(done.stdout, r'AREA +0 bytes  left out: no weighting area')
        for name in ('voxmap', 'pointshell', 'plan'):
            block = re.search(rf'press\.{name} .*?padding to 64', done.stdout, re.S)[0]
            total = sum(int(n.replace(' ', '')) for n in re.findall(r' ([\d ]+) bytes', block))
            self.assertEqual(total, pathlib.Path(self.path('told', f'press.{name}')).stat().st_size)

    def test_weight_of_the_object(self):
        """A ball of a density: gravity and inertia take its mass, and its tensor is that of a ball."""
        effects = [{'kind': 'gravity'}, {'kind': 'inertia'}]
        self.scene('press', dynamic=[{'file': 'ball.stl', 'unit': 'mm', 'density': '1g/cm^3'}], effects=effects, coupling={'kind': 'none'})
        self.convert('press', 'a')
        self.trace('a/press.plan')
        said = json.loads(self.run_voxshell('inspect', 'a/press.plan', '--format', 'json').stdout)['effects']
        constants = {effect['kind']: effect['constants'] for effect in said}
        volume = json.loads(self.run_voxshell('convert', 'ball.stl', '--unit', 'mm', '--voxel', '2mm', '-o', 'b', '--format', 'json').stdout)['parts'][0]['volume_m3']
        mass = 1000 * volume
        self.assertAlmostEqual(constants['gravity'][0] / mass, 1, 6)
        self.assertAlmostEqual(constants['inertia'][0] / mass, 1, 6)
        for moment in constants['inertia'][4:7]:  # of a coarse ball of 12 mm: a few percent below 2/5 m r^2
            self.assertLess(abs(moment / (0.4 * mass * 0.012**2) - 0.96), 0.04)
        self.scene('press', dynamic=[{'file': 'ball.stl', 'unit': 'mm', 'density': '1g/cm^3'}], effects=[{'kind': 'gravity', 'mass': '7g'}])
        self.convert('press', 'c')
        said = json.loads(self.run_voxshell('inspect', 'c/press.plan', '--format', 'json').stdout)['effects']
        self.assertEqual([e['constants'][0] for e in said if e['kind'] == 'gravity'], [0.007])

    def test_inspect_and_diff(self):
        self.convert('press', 'a')
        self.scene('press', guards=[{'kind': 'soft-start', 'time': '200ms'}], rate='500Hz')
        self.convert('press', 'b')
        said = json.loads(self.run_voxshell('inspect', 'b/press.plan', '--format', 'json').stdout)
        self.assertEqual(schema.problems(said, schema.load(command.SOURCE / 'formats' / 'schema' / 'inspect.schema.json')), [])
        self.assertEqual(said['effects'], [{'kind': 'torque', 'constants': []}, {'kind': 'soft-start', 'constants': [0.2]}])
        self.assertEqual([asset['name'] for asset in said['assets']], ['press.voxmap', 'press.pointshell'])
        done = self.run_voxshell('diff', 'a/press.plan', 'b/press.plan', code=6, out=r'rate: 1000 Hz / 500 Hz\n')
        self.assertIn('effect start-inside: 0: no constant / none\n', done.stdout)
        self.assertIn('effect soft-start: 2: time 0.5 s / 1: time 0.2 s\n', done.stdout)
        self.run_voxshell('diff', 'a/press.plan', 'a/press.plan', out='^equal\n$')


if __name__ == '__main__':
    command.main()
