# SPDX-License-Identifier: MIT
"""Assets in numpy: the same as the reader that was written from the specs alone, on every golden and every broken one."""
import gc
import itertools
import os
import pathlib
import sys
import tempfile
import unittest

import numpy as np
import voxshell as vxs

ROOT = pathlib.Path(__file__).resolve().parents[3]
VALID = ROOT / "tests/golden/valid"
sys.path += [str(ROOT / "formats/reference"), str(ROOT / "tests/golden")]

import make_invalid  # noqa: E402
import make_odd  # noqa: E402
import read_asset  # noqa: E402


def verdict(data):
    kind = {b"\x89VXM": vxs.Voxmap, b"\x89VXP": vxs.Pointshell, b"\x89VXL": vxs.Plan}.get(bytes(data[:4]), vxs.Asset)
    try:
        kind.from_bytes(data)
    except vxs.Error as error:
        return f"{error.rule} {error.section} {error.offset}"
    return "OK"


def reference(data):
    try:
        read_asset.read_asset(data)
    except read_asset.Broken as broken:
        if broken.rule != "C303":  # the one rule that a real-time reader leaves out
            return f"{broken.rule} {broken.section} {broken.offset}"
    return "OK"


class Broken(unittest.TestCase):
    def test_same_verdict(self):
        cases = [(name, data) for name, _, data in itertools.chain(make_invalid.cases(), make_odd.invalid())]
        cases += list(make_odd.valid())
        for golden in sorted(VALID.iterdir()):
            data = golden.read_bytes()
            cases += [(f"{golden.name}[:{n}]", data[:n]) for n in (0, 1, 127, 128, 200, len(data) // 2, len(data) - 1)] + [(golden.name, data)]
        self.assertGreater(len(cases), 150)
        for name, data in cases:
            self.assertEqual(verdict(data), reference(data), name)

    def test_from_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "broken.voxmap")
            pathlib.Path(path).write_bytes((VALID / "one_cell.voxmap").read_bytes()[:-64])
            with self.assertRaises(vxs.Error) as caught:
                vxs.Voxmap(path)
            self.assertEqual((caught.exception.result, caught.exception.rule, caught.exception.section), ("VXS_TRUNCATED", "C106", "HEAD"))
            self.assertEqual(str(caught.exception).split(": ")[:3], [path, "shorter or longer than its header says", "rule C106, section HEAD, byte 16"])
            with self.assertRaises(FileNotFoundError):
                vxs.Voxmap(os.path.join(folder, "missing.voxmap"))
        with self.assertRaises(vxs.Error) as caught:
            vxs.Pointshell(VALID / "one_cell.voxmap")
        self.assertEqual(caught.exception.result, "VXS_KIND")


class Goldens(unittest.TestCase):
    def test_header(self):
        for golden in VALID.iterdir():
            asset, other = vxs.open_asset(golden), read_asset.open_asset(golden)
            self.assertEqual(type(asset).__name__, type(other).__name__)
            self.assertEqual((*asset.version, asset.content_hash, asset.source_hash),
                             (other.major, other.minor, other.content_hash.hex(), other.source_hash.hex()))
            self.assertEqual(asset.sections, [s.name for s in other.sections])
            self.assertEqual(asset.bytes.tobytes(), golden.read_bytes())
            self.assertIsInstance(asset.meta, dict)

    def test_cells(self):
        for golden in VALID.glob("*.voxmap"):
            map_, other = vxs.Voxmap(golden), read_asset.open_asset(golden)
            cells = {c[:3]: c[3] for c in other.cells()}
            self.assertEqual({tuple(c) for c in map_.surface().tolist()}, {at for at, state in cells.items() if state == vxs.SURFACE}, golden)
            low, high = map_.bbox[0] - 2, map_.bbox[1] + 2
            states = map_.states(low, high)
            self.assertEqual(np.count_nonzero(states), len(cells))
            for at, state in itertools.islice(cells.items(), 0, None, 97):
                self.assertEqual(states[tuple(np.array(at) - low)], state)
                self.assertEqual(map_.state(at), other.state(*at))
            self.assertEqual((map_.surface_cells, map_.interior_cells), (np.count_nonzero(states == 1), np.count_nonzero(states == 2)))
            self.assertEqual(map_.state([[10**9, 0, 0], [-10**9, 5, 5]]).tolist(), [0, 0])

    def test_channels(self):
        map_ = vxs.Voxmap(VALID / "channels.voxmap")
        cells = np.stack(np.meshgrid(*(np.arange(a - 9, b + 9) for a, b in zip(*map_.bbox)), indexing="ij"), axis=-1)
        state, layer, distance = map_.state(cells), map_.layer(cells), map_.distance(cells)
        beyond = map_.c.layer_count + 1
        self.assertTrue((layer[state == vxs.SURFACE] == 0).all())
        self.assertTrue(((layer[state == vxs.FREE] > 0) & (layer[state == vxs.FREE] <= beyond)).all())
        self.assertTrue(((layer[state == vxs.INTERIOR] < 0) & (layer[state == vxs.INTERIOR] >= -beyond)).all())
        self.assertTrue((np.abs(distance) <= map_.distance_band).all() and (distance[state == vxs.FREE] >= 0).all())
        stored = np.frombuffer(map_.section("DIST").tobytes(), "<i2").reshape(-1, 8, 8, 8)
        self.assertTrue((stored == map_.distances).all() and np.isin(stored * map_.distance_step, distance).all())
        with self.assertRaisesRegex(ValueError, "has no distances"):
            vxs.Voxmap(VALID / "one_cell.voxmap").distance([0, 0, 0])

    def test_points(self):
        for golden in VALID.glob("*.pointshell"):
            shell, other = vxs.Pointshell(golden), list(read_asset.open_asset(golden).points())
            columns = [shell.positions, shell.normals] + ([shell.areas[:, None]] if shell.areas is not None else [])
            self.assertEqual([tuple(row) for row in np.hstack(columns).tolist()], other, golden)
            self.assertEqual(shell.clusters["count"].sum(), len(shell))

    def test_plans(self):
        for golden in VALID.glob("*.plan"):
            plan, other = vxs.Plan(golden), read_asset.open_asset(golden)
            self.assertEqual(plan.assets, [a["name"] for a in other.assets])
            self.assertEqual({kind: list(constants.values()) for kind, constants in plan.effects.items()}, other.effects)
            self.assertEqual([(k["time"], *k["position"], *k["orientation"]) for k in plan.hand], other.hand)
            self.assertEqual([(k["time"], k["asset"], *k["position"], *k["orientation"]) for k in plan.moves], other.moves)
            self.assertEqual((plan.rate, plan.device, plan.arm), (other.rate, other.device, other.arm))
            with self.assertRaises((vxs.Error, OSError)):
                plan.config()  # its assets are not here


class Memory(unittest.TestCase):
    def test_views(self):
        map_, shell, plan = (vxs.open_asset(VALID / name) for name in ("channels.voxmap", "two_clusters.pointshell", "pressed.plan"))
        for asset, names in ((map_, ("root", "chunks", "bricks", "layers", "distances")), (shell, ("positions", "normals", "areas", "clusters")),
                             (plan, ("hand",))):
            start, size = asset.view.data, asset.view.size
            for name in names:
                array = getattr(asset, name)
                at = array.__array_interface__["data"][0]
                self.assertTrue(start <= at and at + array.nbytes <= start + size, name)
                self.assertFalse(array.flags.writeable, name)
                with self.assertRaises(ValueError):
                    array[...] = 0

    def test_array_outlives_its_asset(self):
        maps = pathlib.Path("/proc/self/maps")
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "two.pointshell")
            path.write_bytes((VALID / "two_clusters.pointshell").read_bytes())
            positions = vxs.Pointshell(path).positions
            gc.collect()
            self.assertIn(str(path), maps.read_text(encoding="utf-8"))
            self.assertEqual(positions[:, 0].tolist(), [n / 16 for n in range(70)])
            del positions
            gc.collect()
            self.assertNotIn(str(path), maps.read_text(encoding="utf-8"))
            copied = vxs.Pointshell(path, copy=True)
            self.assertNotIn(str(path), maps.read_text(encoding="utf-8"))
            path.write_bytes(b"")
            self.assertEqual(copied.positions[69, 0], 69 / 16)


if __name__ == "__main__":
    unittest.main()
