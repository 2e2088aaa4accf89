# SPDX-License-Identifier: GPL-3.0-or-later
"""Small solids made here, so that the tests need no data: lists of triangles, written as STL or GLB."""
import json
import math
import pathlib
import struct
import urllib.parse


def box(x=10.0, y=10.0, z=10.0, at=(0.0, 0.0, 0.0)):
    corner = [tuple(at[n] + size * (corner >> n & 1) for n, size in enumerate((x, y, z))) for corner in range(8)]
    quads = (0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)
    return [tuple(corner[n] for n in t) for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def revolve(profile, segments):
    """A profile of (radius, height) turned about +Y, bottom to top, outside to the right."""
    rings = [[(r * math.cos(2 * math.pi * j / segments), y, r * math.sin(2 * math.pi * j / segments)) if r > 1e-9
              else (0.0, y, 0.0) for j in range(segments)] for r, y in profile]
    out = []
    for low, high in zip(rings, rings[1:]):
        for j in range(segments):
            k = (j + 1) % segments
            out += [t for t in ((low[j], high[k], low[k]), (low[j], high[j], high[k])) if len(set(t)) == 3]
    return out


def sphere(radius=10.0, rings=24):
    return revolve([(radius * math.sin(math.pi * i / rings) if 0 < i < rings else 0.0,
                     -radius * math.cos(math.pi * i / rings)) for i in range(rings + 1)], 2 * rings)


def cup(radius=20.0, height=30.0, wall=2.0, segments=48):
    inner = radius - wall
    return revolve([(0.0, 0.0), (radius, 0.0), (radius, height), (inner, height), (inner, wall), (0.0, wall)], segments)


def flipped(triangles):
    return [(a, c, b) for a, b, c in triangles]


def write_stl(path, triangles):
    with open(path, 'wb') as file:
        file.write(b'\0' * 80 + struct.pack('<I', len(triangles)))
        for t in triangles:
            file.write(struct.pack('<12fH', 0, 0, 0, *(x for p in t for x in p), 0))
    return str(path)


def write_glb(path, triangles, scale=1e-3):
    """Indexed, metres (`scale` turns the shape's millimetres into them)."""
    return write_assembly(path, [(None, triangles)], [{'mesh': 0, 'name': 'part'}], scale)


def write_assembly(path, meshes, nodes, scale=1e-3, roots=None, materials=()):
    """(name, triangles[, index of its material]) each, and nodes as glTF has them, all of them roots unless `roots` says which.
    A .gltf has its buffer beside it, with the same name in front of .bin."""
    document = {'asset': {'version': '2.0'}, 'scene': 0, 'scenes': [{'nodes': list(range(len(nodes))) if roots is None else roots}],
                'nodes': nodes, 'meshes': [], 'accessors': [], 'bufferViews': [], 'buffers': []}
    if materials:
        document['materials'] = [{'name': name} for name in materials]
    buffer = b''

    def view(data):
        nonlocal buffer
        document['bufferViews'].append({'buffer': 0, 'byteOffset': len(buffer), 'byteLength': len(data)})
        buffer += data
        return len(document['bufferViews']) - 1

    for name, triangles, *material in meshes:
        index, order = {}, []
        for t in triangles:
            for p in t:
                order.append(index.setdefault(p, len(index)))
        single = [struct.unpack('<3f', struct.pack('<3f', *(x * scale for x in p))) for p in index]
        first = len(document['accessors'])
        document['meshes'].append({'primitives': [{'attributes': {'POSITION': first}, 'indices': first + 1}]})
        if name is not None:
            document['meshes'][-1]['name'] = name
        if material:
            document['meshes'][-1]['primitives'][0]['material'] = material[0]
        document['accessors'] += [
            {'bufferView': view(b''.join(struct.pack('<3f', *p) for p in single)), 'componentType': 5126, 'type': 'VEC3', 'count': len(single),
             'min': [min(p[n] for p in single) for n in range(3)], 'max': [max(p[n] for p in single) for n in range(3)]},
            {'bufferView': view(struct.pack(f'<{len(order)}I', *order)), 'componentType': 5125, 'type': 'SCALAR', 'count': len(order)}]
    document['buffers'] = [{'byteLength': len(buffer)}]
    if str(path).endswith('.gltf'):
        bin_path = pathlib.Path(path).with_suffix('.bin')
        document['buffers'][0]['uri'] = urllib.parse.quote(bin_path.name)
        bin_path.write_bytes(buffer)
        pathlib.Path(path).write_text(json.dumps(document), encoding='utf-8')
        return str(path)
    text = json.dumps(document).encode()
    text += b' ' * (-len(text) % 4)
    with open(path, 'wb') as file:
        file.write(struct.pack('<4sII', b'glTF', 2, 28 + len(text) + len(buffer)))
        file.write(struct.pack('<II', len(text), 0x4E4F534A) + text)
        file.write(struct.pack('<II', len(buffer), 0x004E4942) + buffer)
    return str(path)
