# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene files: thirty wrong ones, each refused with its own line and nothing written; the schema; the example."""
import copy
import json
import pathlib
import re

import command
import schema
import shapes

SCENE = {
    'scene': 'voxshell-scene/1', 'voxel': '2mm', 'static': [{'file': 'cup.glb'}], 'dynamic': [{'file': 'sphere.glb'}],
    'contact': {'law': 'average', 'stiffness': '50N/m'}, 'coupling': {'kind': 'pt2', 'frequency': '5Hz', 'damping': 1},
    'guards': [{'kind': 'start-inside'}, {'kind': 'soft-start'}], 'effects': [], 'device': 'sim:phantom-premium-1.5', 'arm': 'hand',
    'rate': '1kHz',
    'hand': {'path': [{'t': '0s', 'position': ['75mm', '40mm', '0mm']}, {'t': '0.3s', 'position': ['47mm', '40mm', '0mm']}]}}


def at(pointer, value):
    """The scene with the value at a JSON pointer; None takes the key away."""
    scene = copy.deepcopy(SCENE)
    *way, last = [int(step) if step.isdigit() else step for step in pointer.strip('/').split('/')]
    place = scene
    for step in way:
        place = place[step]
    if value is None:
        del place[last]
    elif isinstance(place, list) and last == len(place):
        place.append(value)
    else:
        place[last] = value
    return scene


AREA = {'law': 'patch', 'weighting': 'area', 'stiffness': '1e8N/m^3'}
# pointer, value there, what is said; and whether the schema sees it too (the others contradict in numbers or with files)
WRONG = [
    ('voxle', '2mm', r'/voxle: unknown key; did you mean "voxel"\?', True),
    ('voxel', None, r'/: lacks "voxel"', True),
    ('voxel', 2, r'/voxel: must be a number with its unit in quotes \(m, cm, mm, um or in\)', True),
    ('voxel', '2s', r'/voxel: "2s" is not a number with a unit of m, cm, mm, um or in', True),
    ('voxel', '0mm', r'/voxel: must be above zero', False),
    ('scene', 'voxshell-scene/2', r'/scene: "voxshell-scene/2" is not a version that this voxshell reads', True),
    ('static', [], r'/static: must be a list of 1 to ', True),
    ('static/0/file', '../cup.glb', r"/static/0/file: must be a relative path inside the scene's folder", False),
    ('static/0/pose', {'positon': ['0m', '0m', '0m']}, r'/static/0/pose/positon: unknown key; did you mean "position"\?', True),
    ('static/0/pose', {'rotation': [0, 0, 0, 0]}, r'/static/0/pose/rotation: has no direction: all zero', False),
    ('static/0/unit', 'mm', r'unit', False),
    ('dynamic/1', {'file': 'cup.glb'}, r'/dynamic: must be a list of 1', True),
    ('dynamic/0/up', 'x', r'/dynamic/0/up: "x" is not y or z', True),
    ('contact/law', 'patches', r'/contact/law: "patches" is not original, average, patch or gradient', True),
    ('contact', {'law': 'gradient', 'field': 'layers', 'stiffness': '1N/m'}, r'/contact/field: law gradient takes its direction from field distance', False),
    ('contact', {**AREA, 'stiffness': '500N/m'}, r'/contact/stiffness: "500N/m" is not a number with a unit of N/m\^3 or N/mm\^3', False),
    ('contact/budget', '20us', r'/contact/budget: fewer points weigh the same only with weighting area', False),
    ('coupling', {'kind': 'pt2', 'damping': 1}, r'/coupling: lacks "frequency"', True),
    ('coupling', {'kind': 'none', 'damping': 1}, r'/coupling/damping: unknown key', True),
    ('coupling', {'kind': 'pt2', 'design': 'auto', 'frequency': '5Hz'}, r'/coupling/frequency: unknown key', True),
    ('coupling/frequency', '600Hz', r'/coupling: coupling: natural frequency outside 0\.05 Hz \.\. 0\.49 / sample time', False),
    ('guards', [{'kind': 'slow-start'}], r'/guards/0/kind: "slow-start" is not ', False),
    ('guards', [{'kind': 'soft-start'}, {'kind': 'soft-start'}], r'/guards/1/kind: is there already', False),
    ('guards', [{'kind': 'soft-start', 'time': '4000s'}], r'/guards/0/time: must be 0s to 3600s', False),
    ('guards', [{'kind': 'slew', 'force': '2N'}], r'/guards/0/force: "2N" is not a number with a unit of N/s or N/ms', False),
    ('guards', [{'kind': 'passivity', 'delay': 0.5}], r'/guards/0: ', False),
    ('effects', [{'kind': 'slew'}], r'/effects/0/kind: is a guard: it belongs into "guards"', False),
    ('effects', [{'kind': 'viscosity', 'dampng': '1Ns/m'}], r'/effects/0/dampng: unknown key; did you mean "damping"\?', False),
    ('effects', [{'kind': 'gravity', 'acceleration': ['0m/s^2', '-10m/s^2']}], r'/effects/0/acceleration: must be a list of 3', False),
    ('effects', {'kind': 'gravity'}, r'/effects: must be a list of 0 to ', True),
    ('device', 'sim:omni2', r"no device 'sim:omni2'; there are sim:touch, ", False),
    ('arm', 'foot', r'/arm: "foot" is not free, pen, hand or arm', True),
    ('rate', '1Hz', r'/rate: must be between 10Hz and 100kHz', False),
    ('hand', None, r'/: lacks "hand"', True),
    ('hand/path/1/t', '0s', r'/hand/path/1/t: must be later than the keyframe before it', False),
    ('hand/path/0', {'t': '0s', 'turn': {'about': ['0m', '0m', '0m'], 'axis': [0, 1, 0], 'angle': '1deg'}},
     r'/hand/path/0/turn: the first keyframe has nowhere to turn from', False),
    ('hand/path/1/turn', {'about': ['0m', '0m', '0m'], 'axis': [0, 1, 0], 'angle': '1deg'},
     r'/hand/path/1/position: a turn says itself where it ends', True),
]


class Scene(command.CommandTest):
    def setUp(self):
        super().setUp()
        shapes.write_glb(self.path('cup.glb'), shapes.cup())
        shapes.write_glb(self.path('sphere.glb'), shapes.sphere(12, rings=12))

    def write(self, scene, name='test.scene.json'):
        text = scene if isinstance(scene, str) else json.dumps(scene)
        pathlib.Path(self.path(name)).write_text(text, encoding='utf-8')
        return name

    def test_wrong_scenes(self):
        self.assertGreaterEqual(len(WRONG), 30)
        said = set()
        for pointer, value, pattern, _ in WRONG:
            with self.subTest(pointer=pointer, value=value):
                self.write(at(pointer, value))
                done = self.refused(3, r'test\.scene\.json: .*' + pattern, 'test.scene.json', '-o', 'out', '-q')
                said.add(done.stderr)
        self.assertEqual(len(said), len(WRONG), 'each with a line of its own')

    def test_links(self):
        """A link may lead to a file of the scene's folder, and not out of it."""
        inner = self.folder / 'in'
        inner.mkdir()
        inner.joinpath('cup.glb').symlink_to('../cup.glb')
        inner.joinpath('real.glb').write_bytes(self.folder.joinpath('sphere.glb').read_bytes())
        inner.joinpath('sphere.glb').symlink_to('real.glb')
        self.write(SCENE, 'in/test.scene.json')
        self.refused(3, r"/static/0/file: is a link that leads out of the scene's folder", 'in/test.scene.json', '-o', 'out', '-q')
        inner.joinpath('cup.glb').unlink()
        shapes.write_glb(str(inner / 'cup.glb'), shapes.cup())
        self.run_voxshell('convert', 'in/test.scene.json', '-o', 'out', '-q')

    def test_schema(self):
        rules = schema.load(command.SOURCE / 'formats' / 'schema' / 'scene.schema.json')
        good = [json.loads(p.read_text(encoding='utf-8')) for p in (command.SOURCE / 'samples' / 'scenes').glob('*.json')]
        self.assertGreaterEqual(len(good), 4)
        for scene in [SCENE, at('contact', AREA), at('coupling', {'design': 'auto', 'assume': 'hand'}), *good]:
            self.assertEqual(schema.problems(scene, rules), [])
        for pointer, value, _, seen in WRONG:
            self.assertEqual(schema.problems(at(pointer, value), rules) != [], seen, (pointer, value))

    def test_example(self):
        text = self.run_voxshell('convert', '--example-scene', err='').stdout
        self.write(text, 'example.scene.json')
        self.run_voxshell('convert', 'example.scene.json', '-o', 'out', '-q')
        self.run_voxshell('simulate', 'out/example.plan', '-q')
        bare = json.loads(re.sub(r'//.*', '', text))
        self.assertEqual(schema.problems(bare, schema.load(command.SOURCE / 'formats' / 'schema' / 'scene.schema.json')), [])
        # What stands in comments can be said: each effect with its constants as by default.
        for list_name in ('guards', 'effects'):
            block = re.search(rf'"{list_name}": \[\n(.*?)\n  \],', text, re.S)[1]
            for line in block.splitlines():
                item = json.loads(line.strip().removeprefix('//').strip().rstrip(','))
                self.write({**bare, list_name: [item]})
                if item['kind'] == 'motion':
                    continue  # needs a static with a path
                self.run_voxshell('convert', 'test.scene.json', '-o', 'out', '-q', '--force')

    def test_comments(self):
        self.write('// a comment\n' + json.dumps(SCENE).replace('"arm"', '/* another */ "arm"'))
        self.run_voxshell('convert', 'test.scene.json', '-o', 'out', '-q')
        self.write(json.dumps(SCENE) + ' // not closed /*')
        self.run_voxshell('convert', 'test.scene.json', '-o', 'out', '-q', '--force')
        self.write('/* never closed ' + json.dumps(SCENE))
        self.refused(3, r'not JSON: ', 'test.scene.json', '-o', 'more', '-q')


if __name__ == '__main__':
    command.main()
