# SPDX-License-Identifier: GPL-3.0-or-later
"""A glTF as a whole scene: the same assets and plan as the scene file that says the same; wrong ones refused, each with its line."""
import base64
import copy
import json
import math
import pathlib
import struct

import command
import schema
import shapes

SAID = {'scene': 'voxshell-scene/1', 'voxel': '2mm', 'contact': {'law': 'average', 'stiffness': '50N/m'},
        'coupling': {'kind': 'pt2', 'frequency': '5Hz', 'damping': 1}, 'device': 'sim:phantom-premium-1.5', 'rate': '1kHz'}
HAND = {'path': [{'t': '0s', 'position': ['75mm', '40mm', '0mm']}, {'t': '0.3s', 'position': ['20mm', '15mm', '0mm']}]}


class Builder:
    """A glTF document with its buffer inside."""

    def __init__(self):
        self.body = bytearray()
        self.document = {'asset': {'version': '2.0'}, 'scene': 0, 'scenes': [{'nodes': []}], 'nodes': [], 'meshes': [],
                         'accessors': [], 'bufferViews': []}

    def accessor(self, kind, component, values, width):
        data = struct.pack(f'<{len(values)}{component}', *values)
        self.document['bufferViews'].append({'buffer': 0, 'byteOffset': len(self.body), 'byteLength': len(data)})
        self.body += data
        entry = {'bufferView': len(self.document['bufferViews']) - 1, 'componentType': 5126 if component == 'f' else 5125, 'type': kind,
                 'count': len(values) // width}
        if kind != 'VEC4':
            single = [struct.unpack('<f', struct.pack('<f', x))[0] for x in values] if component == 'f' else values
            entry |= {'min': [min(single[n::width]) for n in range(width)], 'max': [max(single[n::width]) for n in range(width)]}
        self.document['accessors'].append(entry)
        return len(self.document['accessors']) - 1

    def mesh(self, triangles):
        index, order = {}, []
        for t in triangles:
            order += [index.setdefault(p, len(index)) for p in t]
        attributes = {'POSITION': self.accessor('VEC3', 'f', [x * 1e-3 for p in index for x in p], 3)}
        self.document['meshes'].append({'primitives': [{'attributes': attributes, 'indices': self.accessor('SCALAR', 'I', order, 1)}]})
        return len(self.document['meshes']) - 1

    def node(self, name, **facts):
        self.document['nodes'].append({'name': name, **facts})
        return len(self.document['nodes']) - 1

    def animation(self, node, path, times, values, interpolation='LINEAR'):
        width = len(values[0])
        sampler = {'input': self.accessor('SCALAR', 'f', times, 1),
                   'output': self.accessor(f'VEC{width}', 'f', [x for value in values for x in value], width), 'interpolation': interpolation}
        self.document.setdefault('animations', []).append(
            {'channels': [{'sampler': 0, 'target': {'node': node, 'path': path}}], 'samplers': [sampler]})

    def finished(self):
        data = base64.b64encode(self.body).decode()
        return {**self.document, 'buffers': [{'byteLength': len(self.body), 'uri': f'data:application/octet-stream;base64,{data}'}]}


def room():
    """Nodes 0 Cup (turned, moved, under 3 Frame), 1 Post, 2 Ball in the hand, 3 Frame, 4 Lamp without a role, 5 Inner below the ball."""
    built = Builder()
    half = math.sqrt(0.5)
    cup, post, ball = (built.mesh(s) for s in (shapes.cup(), shapes.box(10, 60, 10), shapes.sphere(12, rings=12)))
    built.node('Cup', mesh=cup, rotation=[0, half, 0, half], translation=[0.01, 0, 0], scale=[2, 2, 2], extras={'voxshell': 'static'})
    built.node('Post', mesh=post, translation=[-0.09, 0, 0], extras={'voxshell': {'role': 'static'}})
    built.node('Ball', translation=[0.075, 0.04, 0], children=[5], extras={'voxshell': {'role': 'dynamic', 'density': '1g/cm^3'}})
    built.node('Frame', children=[0], translation=[0, 0.001, 0])
    built.node('Lamp', mesh=post, extras={'note': 'not of the scene'})
    built.node('Inner', mesh=ball, translation=[0, 0.001, 0])
    built.document['scenes'][0] = {'nodes': [3, 1, 2, 4], 'extras': {'voxshell': copy.deepcopy(SAID) | {'hand': copy.deepcopy(HAND)}}}
    return built


def changed(pointer, value):
    """The room with a value at a JSON pointer; None takes the key away."""
    document = room().finished()
    *way, last = [int(step) if step.isdigit() else step for step in pointer.strip('/').split('/')]
    place = document
    for step in way:
        place = place[step]
    if value is None:
        del place[last]
    else:
        place[last] = value
    return document


def animated(node, path, values, interpolation='LINEAR', more=(), keep_hand=True, times=(0.1, 0.4)):
    built = room()
    built.animation(node, path, times, values, interpolation)
    for each in more:
        built.animation(*each)
    if not keep_hand:
        del built.document['scenes'][0]['extras']['voxshell']['hand']
    return built.finished()


WAY = [[-0.09, 0, 0], [-0.05, 0, 0]]
# what, document, what is said
OWN = 'scenes/0/extras/voxshell'
WRONG = [
    ('unknown key', changed(f'{OWN}/voxle', '2mm'), r'/scenes/0/extras/voxshell/voxle: unknown key; did you mean "voxel"\?'),
    ('unit', changed(f'{OWN}/voxel', '2s'), r'/scenes/0/extras/voxshell/voxel: "2s" is not a number with a unit of m, '),
    ('law', changed(f'{OWN}/contact/law', 'patches'), r'/scenes/0/extras/voxshell/contact/law: "patches" is not original, '),
    ('effect', changed(f'{OWN}/effects', [{'kind': 'viscosity', 'dampng': '1Ns/m'}]),
     r'/scenes/0/extras/voxshell/effects/0/dampng: unknown key; did you mean "damping"\?'),
    ('lists', changed(f'{OWN}/static', [{'file': 'cup.glb'}]), r'/scenes/0/extras/voxshell/static: in a glTF nodes say it'),
    ('no extras', changed('scenes/0/extras', None), r'/scenes/0: lacks "extras": {"voxshell"'),
    ('text that is not JSON', changed(OWN, '{"voxel": 2mm}'), r'/scenes/0/extras/voxshell: not JSON: '),
    ('doubled key in text', changed(OWN, '{"rate": "1kHz", "rate": "2kHz"}'), r'/scenes/0/extras/voxshell: key "rate" occurs twice'),
    ('unknown role', changed('nodes/1/extras/voxshell/role', 'statc'), r"/nodes/1 'Post'/extras/voxshell/role: \"statc\" is not static or dynamic"),
    ('unknown role as text', changed('nodes/0/extras/voxshell', 'fixed'), r"/nodes/0 'Cup'/extras/voxshell: \"fixed\" is not static or dynamic"),
    ('unknown key of a node', changed('nodes/2/extras/voxshell', {'role': 'dynamic', 'densty': '1g/cm^3'}),
     r"/nodes/2 'Ball'/extras/voxshell/densty: unknown key; did you mean \"density\"\?"),
    ('weight of what stands', changed('nodes/1/extras/voxshell', {'role': 'static', 'density': '1g/cm^3'}),
     r"/nodes/1 'Post'/extras/voxshell/density: only of what is dynamic"),
    ('two dynamics', changed('nodes/1/extras/voxshell', 'dynamic'), r"/nodes/2 'Ball': is dynamic, as /nodes/1 'Post' is"),
    ('no dynamic', changed('nodes/2/extras', None), r'/nodes: none has the role dynamic'),
    ('role inside a role', changed('nodes/5/extras', {'voxshell': 'static'}), r"/nodes/5 'Inner': has a role inside /nodes/2 'Ball'"),
    ('one name twice', changed('nodes/4/name', 'Cup'), r"/nodes/0 'Cup': has a role, and another node of the scene has its name"),
    ('no name', changed('nodes/1/name', None), r"/nodes/1 '': has a role and no name"),
    ('uneven scale', changed('nodes/1/scale', [1, 2, 1]), r"/nodes/1 'Post': is scaled unevenly, sheared or mirrored"),
    ('mirrored', changed('nodes/3/scale', [-1, 1, 1]), r"/nodes/0 'Cup': is scaled unevenly, sheared or mirrored"),
    ('steps', animated(1, 'translation', WAY, 'STEP'), r"/animations/0/channels/0: /nodes/1 'Post' is animated by STEP: only LINEAR"),
    ('scale animated', animated(1, 'scale', [[1, 1, 1], [2, 2, 2]]), r"/animations/0/channels/0: /nodes/1 'Post' may be moved and turned"),
    ('carrier animated', animated(3, 'translation', WAY), r"/nodes/3 'Frame' carries a part: animate the node with the role"),
    ('inside animated', animated(5, 'translation', WAY), r"/nodes/5 'Inner' is inside a part"),
    ('animated twice', animated(1, 'translation', WAY, more=[(1, 'translation', (0, 1), WAY)]), r"/nodes/1 'Post' has its translation animated twice"),
    ('hand twice', animated(2, 'translation', WAY), r"/nodes/2 'Ball': is animated, and /scenes/0/extras/voxshell/hand says where the hand goes"),
    ('time', animated(1, 'translation', WAY, times=(0.4, 0.1)), r'animations\[0\]\.samplers\[0\]\.input: times do not ascend from 0'),
    ('all move', animated(1, 'translation', WAY, more=[(0, 'translation', (0, 1), WAY)]), r'/nodes: at least one part must stand'),
    ('motion of nothing', changed(f'{OWN}/effects', [{'kind': 'motion'}]),
     r'/nodes: /scenes/0/extras/voxshell/effects/0 asks for motion, and no part says where it goes'),
]


class GltfScene(command.CommandTest):
    def write(self, document, name='room.scene.gltf'):
        pathlib.Path(self.path(name)).write_text(json.dumps(document), encoding='utf-8')
        return name

    def write_json(self, name='room.scene.json', **said):
        pathlib.Path(self.path(name)).write_text(json.dumps({**SAID, 'hand': HAND, **said}), encoding='utf-8')

    def content(self, path):
        return json.loads(self.run_voxshell('inspect', path, '--format', 'json').stdout)['content_hash']

    def same(self, gltf, **said):
        """The scene file that names the same nodes gives the same bytes; of the plan all but the hash of its source, and the same run."""
        self.write(gltf)
        self.write_json(**said)
        self.run_voxshell('convert', 'room.scene.gltf', '-o', 'one', '-q', '--force')
        self.run_voxshell('convert', 'room.scene.json', '-o', 'two', '-q', '--force')
        one, two = self.digests(self.path('one')), self.digests(self.path('two'))
        self.assertEqual(self.content('one/room.plan'), self.content('two/room.plan'))
        self.assertNotEqual(one.pop('room.plan'), two.pop('room.plan'))
        self.assertEqual(one, two)
        self.run_voxshell('verify', 'one', '--against', 'room.scene.gltf')
        for scene, trace in (('room.scene.gltf', 'one.csv'), ('room.scene.json', 'two.csv'), ('one/room.plan', 'plan.csv')):
            self.run_voxshell('simulate', scene, '--trace', trace, '--force', '-q')
        rows = pathlib.Path(self.path('one.csv')).read_bytes()
        self.assertGreater(len(rows.splitlines()), 200)
        self.assertEqual(rows, pathlib.Path(self.path('two.csv')).read_bytes())
        self.assertEqual(rows, pathlib.Path(self.path('plan.csv')).read_bytes())
        return one

    def nodes(self, *names):
        return [{'file': 'room.scene.gltf', 'node': name} for name in names]

    def test_same_as_the_scene_file(self):
        ball = {**self.nodes('Ball')[0], 'density': '1g/cm^3'}
        made = self.same(room().finished(), static=self.nodes('Cup', 'Post'), dynamic=[ball])
        # Extras as text, as an editor of properties may hold them, say the same.
        document = room().finished()
        for holder in (document['scenes'][0], document['nodes'][2]):
            holder['extras']['voxshell'] = json.dumps(holder['extras']['voxshell'])
        self.same(document, static=self.nodes('Cup', 'Post'), dynamic=[ball])
        # And where the parts of two plain files stand where the nodes do, cells and points are the same.
        shapes.write_glb(self.path('cup.glb'), shapes.cup(), scale=2e-3)
        shapes.write_glb(self.path('post.glb'), shapes.box(10, 60, 10))
        shapes.write_glb(self.path('ball.glb'), shapes.sphere(12, rings=12))
        half = math.sqrt(0.5)
        self.write_json('plain.scene.json', dynamic=[{'file': 'ball.glb', 'pose': {'position': ['0m', '0.001m', '0m']}}], static=[
            {'file': 'cup.glb', 'pose': {'position': ['0.01m', '0.001m', '0m'], 'rotation': [0, half, 0, half]}},
            {'file': 'post.glb', 'pose': {'position': ['-0.09m', '0m', '0m']}}])
        self.run_voxshell('convert', 'plain.scene.json', '-o', 'plain', '-q')
        self.run_voxshell('diff', 'one/room.voxmap', 'plain/plain.voxmap', out='equal')
        self.run_voxshell('diff', 'one/room.pointshell', 'plain/plain.pointshell', '--tolerance', '0.001um', out='equal')
        self.assertEqual(len(made), 3)

    def test_animation(self):
        """A part's animation is its path, the dynamic's is the hand's: keys of both channels, between them each on its own line."""
        half = math.sqrt(0.5)
        document = animated(1, 'translation', [[-0.09, 0, 0], [-0.06, 0, 0]], more=[
            (1, 'rotation', (0.1, 0.7), [[0, 0, 0, 1], [0, half, 0, half]]),
            (2, 'translation', (0, 0.25), [[0.075, 0.04, 0], [0.0625, 0.04, 0]])], keep_hand=False)
        times = (0.1, 0.4, 0.7)
        single = [struct.unpack('<f', struct.pack('<f', t))[0] for t in times]
        angles = (0, 45, 90)
        places = (-0.09, -0.06, -0.06)
        path = [{'t': f'{t!r}s', 'position': [f'{struct.unpack("<f", struct.pack("<f", x))[0]!r}m', '0m', '0m'],
                 'rotation': [0, math.sin(math.radians(a) / 2), 0, math.cos(math.radians(a) / 2)]} for t, x, a in zip(single, places, angles)]
        self.write(document)
        self.write_json(static=[*self.nodes('Cup'), {**self.nodes('Post')[0], 'path': path}], dynamic=self.nodes('Ball'), hand={'path': [
            {'t': '0s', 'position': ['75mm', '40mm', '0mm']}, {'t': '0.25s', 'position': ['62.5mm', '40mm', '0mm']}]})
        for ending in ('gltf', 'json'):
            self.run_voxshell('convert', f'room.scene.{ending}', '-o', ending, '-q')
        self.assertEqual({n: h for n, h in self.digests(self.path('gltf')).items() if n != 'room.plan'},
                         {n: h for n, h in self.digests(self.path('json')).items() if n != 'room.plan'})
        done = self.run_voxshell('simulate', 'room.scene.gltf', '--seconds', '1', '--format', 'json')
        self.assertEqual(json.loads(done.stdout)['ticks'], 1000)
        rows = []
        for ending in ('gltf', 'json'):
            self.run_voxshell('simulate', f'room.scene.{ending}', '--seconds', '1', '--trace', f'{ending}.csv', '-q')
            rows.append([[float(x) for x in line.split(',')] for line in pathlib.Path(self.path(f'{ending}.csv')).read_text().splitlines()[1:]])
        worst = max(abs(a - b) for one, two in zip(*rows) for a, b in zip(one, two))
        self.assertLess(worst, 1e-6)
        # The nodes' animations are used, so nothing is said of them.
        done = self.run_voxshell('convert', 'room.scene.gltf', '-o', 'more')
        self.assertNotIn('animation', done.stderr)

    def test_binary_sample(self):
        """The sample, with all that a scene file has: converts, explains, simulates, designs."""
        models = command.SOURCE / 'samples' / 'models' / 'generate.py'
        command.subprocess.run([command.sys.executable, models, self.path('models')], check=True)
        self.run_voxshell('convert', 'models/between.scene.glb', '-o', 'out', '--explain', out='MOVE .* the effect motion')
        self.assertEqual(sorted(self.listing(self.path('out'))),
                         ['between.moving1.voxmap', 'between.plan', 'between.pointshell', 'between.vdb', 'between.voxmap'])
        done = self.run_voxshell('simulate', 'out/between.plan', '--seconds', '1.5', '--format', 'json')
        self.assertGreater(json.loads(done.stdout)['contact_ticks'], 100)
        self.run_voxshell('design', 'models/between.scene.glb', '--assume', 'hand', out='as given')
        self.run_voxshell('convert', 'models/between.scene.glb', '-o', 'not', '--dry-run', out='between/moving')

    def test_where_nothing_is_said(self):
        """Without a hand and without an animation the hand rests where the node is."""
        document = changed(f'{OWN}/hand', None)
        self.write(document)
        done = self.run_voxshell('simulate', 'room.scene.gltf', '--seconds', '0.1', '--format', 'json')
        self.assertEqual(json.loads(done.stdout)['contact_ticks'], 0)

    def test_wrong_scenes(self):
        said = set()
        for what, document, pattern in WRONG:
            with self.subTest(what):
                self.write(document)
                said.add(self.refused(3, r'room\.scene\.gltf: .*' + pattern, 'room.scene.gltf', '-o', 'out', '-q').stderr)
        self.assertEqual(len(said), len(WRONG), 'each with a line of its own')
        self.write_json(static=self.nodes('Cap'), dynamic=self.nodes('Ball'))
        self.write(room().finished())
        self.refused(3, r"the scene has no node 'Cap'", 'room.scene.json', '-o', 'out', '-q')
        shapes.write_stl(self.path('ball.stl'), shapes.sphere(12, rings=12))
        self.write_json(static=self.nodes('Cup'), dynamic=[{'file': 'ball.stl', 'unit': 'mm', 'node': 'Ball'}])
        self.refused(3, r'/dynamic/0/node: only of glTF', 'room.scene.json', '-o', 'out', '-q')
        self.refused(1, '--voxel and --up: not for a scene', 'room.scene.gltf', '-o', 'out', '--voxel', '1mm')
        self.write(room().finished(), 'room.gltf')
        self.refused(5, r'a scene ends in \.scene\.json, \.scene\.gltf or \.scene\.glb', 'room.gltf', verb='simulate')

    def test_schema(self):
        rules = schema.load(command.SOURCE / 'formats' / 'schema' / 'scene.schema.json')
        extras, node = ({'$ref': f'#/$defs/{name}'} for name in ('gltf_scene', 'gltf_node'))
        document = room().finished()
        self.assertEqual(schema.problems(document['scenes'][0]['extras']['voxshell'], extras, rules), [])
        for each in document['nodes']:
            if 'voxshell' in each.get('extras', {}):
                self.assertEqual(schema.problems(each['extras']['voxshell'], node, rules), [])
        self.assertNotEqual(schema.problems({**SAID, 'static': []}, extras, rules), [])
        self.assertNotEqual(schema.problems({'role': 'static', 'density': '1g/cm^3'}, node, rules), [])
        self.assertNotEqual(schema.problems('fixed', node, rules), [])


if __name__ == '__main__':
    command.main()
