#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes the test bed of the paper's figure 12 as CAD files: generate.py FOLDER

    cup.glb     cup.stl      radius 40 mm outside, 34 mm inside, 80 mm high, floor 6 mm; stands on y = 0
    sphere.glb  sphere.stl   radius 15 mm, round the origin
    ring.glb                 radius 20 mm outside, 10 mm inside, 30 mm high: a hole
    peg.glb                  radius 9.9 mm, 40 mm high: fits into it; both stand on y = 0
    pair.glb                 one bracket, two nodes: as it is, and mirrored
    between.scene.glb        a whole scene in one file: the cup stands, the peg comes and goes, the sphere is in the hand

glTF in metres, STL (binary) in millimetres, both +Y up, closed, counter-clockwise seen from outside.
The same bytes on every machine: coordinates are rounded to a nanometre, so that no C library's last
digit matters. The standard library is all it needs.
"""
import json
import math
import pathlib
import struct
import sys

if sys.version_info < (3, 9):
    sys.exit("%s: needs Python 3.9 or newer, and this is %d.%d" % ((sys.argv[0],) + sys.version_info[:2]))

EDGE = 2.0  # length that the edges of triangles aim at [mm]
TURN = 128  # vertices round the cup: a chord leaves the circle by at most 0.012 mm


class Mesh:
    """Vertices in millimetres; triangles wind counter-clockwise seen from outside."""

    def __init__(self):
        self.vertices, self.triangles, self._index = [], [], {}

    def vertex(self, x, y, z):
        """Index of the vertex there, the same for the same place: parts of a mesh share their seams."""
        at = tuple(round(c, 6) + 0.0 for c in (x, y, z))  # + 0.0: no negative zero
        if at not in self._index:
            self._index[at] = len(self.vertices)
            self.vertices.append(at)
        return self._index[at]

    def triangle(self, a, b, c):
        if a != b and b != c and c != a:
            self.triangles.append((a, b, c))


def ring(mesh, radius, y, count):
    """Vertex indices round the Y axis, from +X towards -Z: counter-clockwise seen from above."""
    return [mesh.vertex(radius * math.cos(2 * math.pi * n / count), y,
                        -radius * math.sin(2 * math.pi * n / count)) for n in range(count)]


def stitch(mesh, inner, outer):
    """Triangles between two rings round the Y axis; faces +Y if `outer` has the larger radius, and outwards
    if `inner` lies above. The rings may differ in count: always the ring that lags behind takes the next step."""
    a = b = 0
    while a < len(inner) or b < len(outer):
        i, o = inner[a % len(inner)], outer[b % len(outer)]
        if b == len(outer) or (a < len(inner) and (2 * a + 1) * len(outer) < (2 * b + 1) * len(inner)):
            a += 1
            mesh.triangle(i, o, inner[a % len(inner)])
        else:
            b += 1
            mesh.triangle(i, o, outer[b % len(outer)])


def steps(length):
    return max(1, round(length / EDGE))


def wall(mesh, radius, low, high, outwards):
    count = steps(high - low)
    rows = [ring(mesh, radius, low + (high - low) * n / count, TURN) for n in range(count + 1)]
    for lower, upper in zip(rows, rows[1:]):
        stitch(mesh, *((upper, lower) if outwards else (lower, upper)))


def disc(mesh, inner_radius, outer_radius, y, up):
    """A flat ring, or a whole disc for inner_radius 0, with fewer vertices where the circle is smaller."""
    count = steps(outer_radius - inner_radius)
    rows = []
    for n in range(count + 1):
        radius = inner_radius + (outer_radius - inner_radius) * n / count
        if n == count or inner_radius > 0:
            rows.append(ring(mesh, radius, y, TURN))
        elif n == 0:
            rows.append([mesh.vertex(0, y, 0)])
        else:
            rows.append(ring(mesh, radius, y, 6 * round(TURN / 6 * n / count)))
    for smaller, larger in zip(rows, rows[1:]):
        stitch(mesh, *((smaller, larger) if up else (larger, smaller)))


def cup(outer=40.0, inner=34.0, height=80.0, floor=6.0):
    mesh = Mesh()
    disc(mesh, 0, outer, 0, up=False)
    wall(mesh, outer, 0, height, outwards=True)
    disc(mesh, inner, outer, height, up=True)
    wall(mesh, inner, floor, height, outwards=False)
    disc(mesh, 0, inner, floor, up=True)
    return mesh


def tube(outer=20.0, inner=10.0, height=30.0):
    mesh = Mesh()
    disc(mesh, inner, outer, 0, up=False)
    wall(mesh, outer, 0, height, outwards=True)
    disc(mesh, inner, outer, height, up=True)
    wall(mesh, inner, 0, height, outwards=False)
    return mesh


def peg(radius=9.9, height=40.0):
    mesh = Mesh()
    disc(mesh, 0, radius, 0, up=False)
    wall(mesh, radius, 0, height, outwards=True)
    disc(mesh, 0, radius, height, up=True)
    return mesh


def sphere(radius=15.0, frequency=16):
    """An icosahedron with each face cut into frequency^2 triangles, pushed out to the sphere."""
    g = (1 + math.sqrt(5)) / 2
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g),
               (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
             (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5),
             (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    mesh = Mesh()
    for face in faces:
        a, b, c = (corners[n] for n in face)

        def at(i, j):
            k = frequency - i - j
            p = [(i * x + j * y + k * z) / frequency for x, y, z in zip(a, b, c)]
            scale = radius / math.sqrt(sum(x * x for x in p))
            return mesh.vertex(*(scale * x for x in p))

        for i in range(frequency):
            for j in range(frequency - i):
                mesh.triangle(at(i + 1, j), at(i, j + 1), at(i, j))
                if i + j < frequency - 1:
                    mesh.triangle(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1))
    return mesh


def bracket(long=30.0, short=18.0, thick=6.0, deep=12.0):
    """An L profile, extruded along Z: no symmetry, so that a lost mirror shows."""
    outline = [(0, 0), (long, 0), (long, thick), (thick, thick), (thick, short), (0, short)]
    faces = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    mesh = Mesh()
    front = [mesh.vertex(x, y, deep) for x, y in outline]
    back = [mesh.vertex(x, y, 0) for x, y in outline]
    for a, b, c in faces:
        mesh.triangle(front[a], front[b], front[c])
        mesh.triangle(back[c], back[b], back[a])
    for n in range(len(outline)):
        m = (n + 1) % len(outline)
        mesh.triangle(back[n], back[m], front[m])
        mesh.triangle(back[n], front[m], front[n])
    return mesh


def check(name, mesh):
    """Closed, and outward all over: every edge is used once in each direction, the volume is positive."""
    edges = set()
    for a, b, c in mesh.triangles:
        for edge in ((a, b), (b, c), (c, a)):
            if edge in edges:
                sys.exit(f"{name}: edge {edge} is used twice in one direction")
            edges.add(edge)
    if any((b, a) not in edges for a, b in edges):
        sys.exit(f"{name}: not closed")
    volume = 0.0
    for a, b, c in mesh.triangles:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (mesh.vertices[n] for n in (a, b, c))
        volume += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    if volume <= 0:
        sys.exit(f"{name}: inside out")


def stl(name, mesh):
    """Binary STL in millimetres."""
    out = bytearray(f"{name}, millimetres, +Y up".encode().ljust(80) + struct.pack("<I", len(mesh.triangles)))
    for triangle in mesh.triangles:
        a, b, c = (mesh.vertices[n] for n in triangle)
        u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
        n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        length = math.sqrt(sum(x * x for x in n))
        out += struct.pack("<12fH", *(round(x / length, 6) + 0.0 for x in n), *a, *b, *c, 0)
    return bytes(out)


def glb(name, mesh, nodes):
    """glTF 2.0, binary, metres: one mesh, the given nodes."""
    points = [struct.unpack("<3f", struct.pack("<3f", *(x / 1000 for x in p))) for p in mesh.vertices]
    indices = struct.pack(f"<{3 * len(mesh.triangles)}H", *(n for t in mesh.triangles for n in t))
    indices += bytes(-len(indices) % 4)
    positions = b"".join(struct.pack("<3f", *p) for p in points)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": [{**node, "mesh": 0} for node in nodes],
        "meshes": [{"name": name, "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(points),
             "min": [min(p[n] for p in points) for n in range(3)],
             "max": [max(p[n] for p in points) for n in range(3)]},
            {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 3 * len(mesh.triangles)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(positions), "target": 34962},
            {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices), "target": 34963}],
        "buffers": [{"byteLength": len(positions) + len(indices)}]}
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    body = positions + indices
    return (struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(body)) +
            struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body)


def whole_scene():
    """glTF 2.0, binary: nodes with roles, a scene with the rest of a scene file, both in "extras", as CAD programs write
    what people note on objects. What is animated moves: the peg by itself, the sphere with the hand."""
    body, views, accessors = bytearray(), [], []

    def accessor(kind, component, values, width):
        views.append({"buffer": 0, "byteOffset": len(body), "byteLength": struct.calcsize(component) * len(values)})
        body.extend(struct.pack(f"<{len(values)}{component}", *values))
        body.extend(bytes(-len(body) % 4))
        single = [struct.unpack("<f", struct.pack("<f", x))[0] for x in values] if component == "f" else values
        accessors.append({"bufferView": len(views) - 1, "componentType": 5126 if component == "f" else 5123, "type": kind,
                          "count": len(values) // width, "min": [min(single[n::width]) for n in range(width)],
                          "max": [max(single[n::width]) for n in range(width)]})
        return len(accessors) - 1

    def mesh(name, of):
        return {"name": name, "primitives": [{
            "attributes": {"POSITION": accessor("VEC3", "f", [x / 1000 for p in of.vertices for x in p], 3)},
            "indices": accessor("SCALAR", "H", [n for t in of.triangles for n in t], 1)}]}

    def way(node, *stops):
        """Animation channels of (time, position [mm])."""
        times = accessor("SCALAR", "f", [t for t, _ in stops], 1)
        places = accessor("VEC3", "f", [x / 1000 for _, at in stops for x in at], 3)
        return {"channels": [{"sampler": 0, "target": {"node": node, "path": "translation"}}],
                "samplers": [{"input": times, "output": places, "interpolation": "LINEAR"}]}

    document = {
        "asset": {"version": "2.0"}, "scene": 0,
        "scenes": [{"name": "between", "nodes": [0, 1, 2], "extras": {"voxshell": {
            "scene": "voxshell-scene/1", "voxel": "2mm",
            "contact": {"law": "patch", "field": "layers", "stiffness": "50N/m", "most_stiffness": "400N/m"},
            "coupling": {"kind": "pt2", "frequency": "5Hz", "damping": 1},
            "effects": [{"kind": "motion", "loop": 0}]}}}],
        "nodes": [
            {"name": "Cup", "mesh": 0, "extras": {"voxshell": "static"}},
            {"name": "Peg", "mesh": 1, "translation": [0.14, 0.02, 0], "extras": {"voxshell": "static"}},
            {"name": "Sphere", "mesh": 2, "translation": [0.07, 0.04, 0], "extras": {"voxshell": {"role": "dynamic", "density": "1g/cm^3"}}}],
        "meshes": [mesh("cup", cup()), mesh("peg", peg()), mesh("sphere", sphere())],
        "animations": [way(1, (0, (140, 20, 0)), (0.5, (140, 20, 0)), (1, (86, 20, 0)), (1.5, (140, 20, 0))),
                       way(2, (0, (70, 40, 0)), (0.4, (52, 40, 0)), (0.8, (66, 40, 0)), (1.6, (66, 40, 0)))]}
    document |= {"accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(body)}]}
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(body)) +
            struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + bytes(body))


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    files = {}
    for name, mesh in (("cup", cup()), ("sphere", sphere())):
        check(name, mesh)
        files[f"{name}.glb"] = glb(name, mesh, [{"name": name}])
        files[f"{name}.stl"] = stl(name, mesh)
    for name, mesh in (("ring", tube()), ("peg", peg())):
        check(name, mesh)
        files[f"{name}.glb"] = glb(name, mesh, [{"name": name}])
    mesh = bracket()
    check("bracket", mesh)
    files["pair.glb"] = glb("bracket", mesh, [
        {"name": "right", "translation": [0.01, 0, 0]},
        {"name": "left", "translation": [-0.01, 0, 0], "scale": [-1, 1, 1]}])
    files["between.scene.glb"] = whole_scene()
    for name, content in files.items():
        (folder / name).write_bytes(content)


if __name__ == "__main__":
    main()
