# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact and servo through Python: the golden wrenches, and the command line's trace, to the last bit."""
import csv
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import voxshell as vxs
from voxshell.contact import FIELDS, LAWS, WEIGHTINGS, ContactConfig

ROOT = pathlib.Path(__file__).resolve().parents[3]
SAMPLES = pathlib.Path(os.environ["VOXSHELL_BUILD"], "samples")
MASK = (1 << 64) - 1
POSES = 10000


def setUpModule():
    global FOLDER
    FOLDER = pathlib.Path(tempfile.mkdtemp(prefix="voxshell-python-"))
    unittest.addModuleCleanup(shutil.rmtree, FOLDER)
    for part in ("cup.glb", "sphere.glb"):
        voxshell("convert", SAMPLES / part, "-o", FOLDER, "--voxel", "1mm", "--channels", "layers:3,distance:3", "-q")
    for scene in ("cup_hold", "cup_slide", "peg_in_hole"):
        voxshell("convert", SAMPLES / f"{scene}.scene.json", "-o", FOLDER, "-q")


def voxshell(*words):
    subprocess.run([os.environ["VOXSHELL"], *map(str, words)], check=True, stdout=subprocess.DEVNULL)


class Dice:
    """Of tests/runtime/contact_trajectory.c, which wrote the golden file."""

    def __init__(self):
        self.state = 88172645463325252

    def uniform(self):
        self.state ^= self.state << 13 & MASK
        self.state ^= self.state >> 7
        self.state ^= self.state << 17 & MASK
        return float(self.state >> 11) * 2.0**-53 * 2 - 1

    def pose(self, map_):
        numbers = []
        for low, high in zip(*(map_.voxel * map_.bbox).tolist()):
            numbers.append(0.5 * (low + high) + 0.7 * (high - low) * self.uniform())
        return numbers + [self.uniform() for _ in range(4)]


def config_of(n):
    config = ContactConfig.default()
    config.law = LAWS[("average", "original", "gradient")[n % 3]]
    if config.law == LAWS["gradient"]:
        config.field = FIELDS["distance"]
    config.weighting = WEIGHTINGS[("count", "area", "count-capped")[n // 3 % 3]]
    config.reference[0] = 0.001 * (n % 5)
    return config


def deep_config_of(n):
    config = config_of(n // 8)
    config.law = LAWS[("patch", "original", "average", "patch", "original", "average", "gradient", "patch")[n % 8]]
    config.field = FIELDS[("surface", "layers", "layers", "layers", "distance", "distance", "distance", "distance")[n % 8]]
    if n // 8 % 5 == 0:
        config.most_stiffness = 0.05 if config.weighting == WEIGHTINGS["area"] else 5000
    return config


def fnv(results):
    """FNV-1a of what a golden wrench consists of, one result after the other."""
    packed = np.zeros(len(results), [("force", "<f8", 3), ("torque", "<f8", 3), ("normal", "<f8", 3), ("depth", "<f8"), ("counts", "<u4", 4)])
    packed["force"], packed["torque"] = results["wrench"]["force"], results["wrench"]["torque"]
    for name in ("normal", "depth"):
        packed[name] = results[name]
    for n, name in enumerate(("points", "deep_points", "patches", "flags")):
        packed["counts"][:, n] = results[name]
    value = 14695981039346656037
    for byte in packed.tobytes():
        value = (value ^ byte) * 1099511628211 & MASK
    return value


class GoldenWrenches(unittest.TestCase):
    def test_to_the_last_bit(self):
        cup, ball = vxs.Voxmap(FOLDER / "cup.voxmap"), vxs.Pointshell(FOLDER / "sphere.pointshell")
        golden = (ROOT / "tests/golden/contact_trajectory.txt").read_text(encoding="utf-8")
        one, two, dice = vxs.Contact(ball, cup), vxs.Contact(ball, [cup, (cup, (0, 0, 0))]), Dice()
        self.assertEqual(self.told("random", self.at_random(config_of, POSES, cup, one, two, dice)), self.part(golden, "random", POSES))
        # The walk between draws from the same dice: a goal every 400 poses.
        for _ in range(0, POSES // 4, 400):
            dice.pose(cup)
        results = self.at_random(deep_config_of, POSES // 5, cup, one, two, dice)
        self.assertEqual(self.told("random deep", results), self.part(golden, "random deep", POSES // 5))

    @staticmethod
    def at_random(make, poses, cup, one, two, dice):
        results = np.zeros(poses, vxs.contact.RESULT)
        for n in range(poses):
            pose, moved = dice.pose(cup), dice.pose(cup)
            touch = two if n % 7 == 0 else one
            two.statics.poses[1].position[:], two.statics.poses[1].orientation[:] = moved[:3], moved[3:]
            touch.config = make(n)
            results[n] = touch.evaluate(pose)
        return results

    @staticmethod
    def part(golden, name, poses):
        return re.search(rf"^{name} {poses} poses.*$", golden, re.M)[0]

    @staticmethod
    def told(name, results):
        return (f"{name} {len(results)} poses: {np.count_nonzero(results['points'])} touch, {np.count_nonzero(results['deep_points'])} deep, "
                f"{results['points'].sum(dtype=np.int64)} points, hash {fnv(results):016x}")


class Contact(unittest.TestCase):
    def test_many_poses_are_one_after_the_other(self):
        cup, ball = vxs.Voxmap(FOLDER / "cup.voxmap"), vxs.Pointshell(FOLDER / "sphere.pointshell")
        poses = np.zeros((3, 5, 3))
        poses[..., 0], poses[..., 1] = np.linspace(0.057, 0.053, 15).reshape(3, 5), 0.04
        touch = vxs.Contact(ball, cup, law="patch", field="distance", weighting="area", stiffness=3e8)
        many = touch.evaluate(poses)
        self.assertEqual(many.shape, (3, 5))
        self.assertEqual([touch.evaluate(pose).tobytes() for pose in poses.reshape(-1, 3)], [one.tobytes() for one in many.reshape(-1)])
        force = many["wrench"]["force"][..., 0].reshape(-1)
        self.assertTrue((np.diff(force) >= 0).all() and force[0] == 0 and force[-1] > 1)
        self.assertEqual(touch.evaluate([np.nan, 0, 0])["flags"], vxs.ContactFlag.INVALID)

    def test_refusals(self):
        cup, bare, ball = vxs.Voxmap(FOLDER / "cup.voxmap"), vxs.Voxmap(FOLDER / "cup_slide.voxmap"), vxs.Pointshell(FOLDER / "sphere.pointshell")
        for result, maps, more in (("VXS_LAW_FIELD", cup, {"law": "gradient"}), ("VXS_PARAM", cup, {"stiffness": -1}),
                                   ("VXS_CHANNEL", bare, {"field": "layers"})):
            with self.assertRaises(vxs.Error) as caught:
                vxs.Contact(ball, maps, **more)
            self.assertEqual(caught.exception.result, result)
        with self.assertRaisesRegex(ValueError, "law 'averge': there are original, average"):
            vxs.Contact(ball, cup, law="averge")
        with self.assertRaisesRegex(ValueError, r"shape \(4,\)"):
            vxs.Contact(ball, cup).evaluate([1, 2, 3, 4])


class Simulation(unittest.TestCase):
    COLUMNS = [(f"{what}_{axis}_m", part, "position", n) for what, part in (("device", "pose"), ("body", "body")) for n, axis in enumerate("xyz")] + \
              [(f"{what}_f{axis}_n", part, "force", n) for what, part in (("collision", "collision"), ("output", "command")) for n, axis in enumerate("xyz")]

    def test_as_the_command_line_does(self):
        for scene in ("cup_hold", "cup_slide", "peg_in_hole"):
            trace = FOLDER / f"{scene}.csv"
            voxshell("simulate", SAMPLES / f"{scene}.scene.json", "--assets", FOLDER, "--trace", trace)
            with open(trace, encoding="utf-8") as file:
                told = list(csv.DictReader(file))
            plan = vxs.Plan(FOLDER / f"{scene}.plan")
            rows = plan.simulate()
            self.assertEqual(len(rows), len(told))
            for column, part, kind, n in self.COLUMNS:
                self.assertEqual(rows[part][kind][:, n].tolist(), [float(row[column]) for row in told], f"{scene} {column}")
            self.assertEqual(rows["flags"].tolist(), [int(row["flags"]) for row in told])
            self.assertGreater(rows["points"].max(), 0)

    def test_an_experiment(self):
        plan = vxs.Plan(FOLDER / "cup_hold.plan")
        peaks = []
        for stiffness in (200.0, 400.0, 800.0):
            config = plan.config()
            config.coupling.stiffness = stiffness
            rows = plan.simulate(config, seconds=1.5)
            peaks.append(np.abs(rows["command"]["force"][:, 0]).max())
        self.assertEqual(peaks, sorted(peaks))
        self.assertGreater(peaks[2], 1.5 * peaks[0])
        noisy = [plan.simulate(noise=2e-5, seed=seed).tobytes() for seed in (1, 1, 2)]
        self.assertEqual(noisy[0], noisy[1])
        self.assertNotEqual(noisy[0], noisy[2])

    def test_own_loop(self):
        """A tick of one's own: the state by hand."""
        config, state = vxs.Plan(FOLDER / "cup_hold.plan").config(), vxs.DeviceState()
        servo, rows = vxs.Servo(config), np.zeros(1000, vxs.ROW)
        state.state = vxs.ARMED
        state.pose.orientation[0] = 1
        for n in range(len(rows)):
            state.sequence, state.time_ns = n + 1, n * 1000000
            state.pose.position[:] = 0.075 - 0.028 * n / 1000, 0.04, 0
            servo.tick(state, rows, n)
        self.assertEqual(rows["tick"].tolist(), list(range(1000)))
        self.assertGreater(servo.command.wrench.force[0], 1)
        self.assertEqual(servo.command.wrench.force[0], rows["command"]["force"][-1, 0])
        state.pose.position[0] = float("nan")
        self.assertTrue(servo.tick(state) & vxs.ServoFlag.FAULT)
        self.assertEqual(list(servo.command.wrench.force), [0, 0, 0])
        with self.assertRaises(IndexError):
            servo.tick(state, rows, 1000)

    def test_refusals(self):
        folder = FOLDER / "other"
        folder.mkdir()
        shutil.copy(FOLDER / "cup_hold.plan", folder)
        shutil.copy(FOLDER / "cup_slide.voxmap", folder / "cup_hold.voxmap")
        shutil.copy(FOLDER / "cup_hold.pointshell", folder)
        plan = vxs.Plan(folder / "cup_hold.plan")
        with self.assertRaises(vxs.Error) as caught:
            plan.simulate()
        self.assertEqual(caught.exception.result, "VXS_PLAN")
        self.assertIn("cup_hold.voxmap: the plan was made for other assets than these", str(caught.exception))
        config = plan.config(FOLDER)
        config.coupling.stiffness = -1
        with self.assertRaises(vxs.Error) as caught:
            plan.simulate(config)
        self.assertEqual(caught.exception.result, "VXS_IMPEDANCE")
        with self.assertRaisesRegex(ValueError, "device 'none': there are touch, omni"):
            plan.simulate(plan.config(FOLDER), device="sim:none")
        with self.assertRaisesRegex(ValueError, "arm 'foot': there are free, pen"):
            plan.simulate(plan.config(FOLDER), arm="foot")
        with self.assertRaises(vxs.Error):
            plan.simulate(plan.config(FOLDER), delay=0)
        with self.assertRaises(FileNotFoundError):
            plan.config(folder / "none")


class Sample(unittest.TestCase):
    def test_experiment(self):
        done = subprocess.run([sys.executable, ROOT / "samples/experiment/experiment.py", FOLDER / "cup_hold.plan", "-o", "stimuli"], cwd=FOLDER,
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, "touch: 100, 200, .*N/m are felt as asked")
        with open(FOLDER / "stimuli.csv", encoding="utf-8") as file:
            table = list(csv.DictReader(file))
        self.assertEqual(len(table), 24)
        for row in table:  # two springs in series: softer than either, and ever more so
            asked, felt = float(row["asked_n_per_m"]), float(row["felt_n_per_m"])
            self.assertTrue(0.7 * asked < felt < asked, row)
        if shutil.which("gnuplot"):
            self.assertIn("phantom-premium-1.5", (FOLDER / "stimuli.svg").read_text(encoding="utf-8"))

    def test_assembly(self):
        voxshell("batch", SAMPLES / "pair.glb", "--per-part", "--voxel", "2mm", "-o", FOLDER / "asm", "-q")
        done = subprocess.run([sys.executable, ROOT / "samples/assembly/assembly.py", FOLDER / "asm/pair/assembly.json", FOLDER / "sphere.pointshell"],
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, "2 maps for 2 instances\nfrom -.* places touch")


if __name__ == "__main__":
    unittest.main()
