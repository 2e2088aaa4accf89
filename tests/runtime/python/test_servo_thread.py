# SPDX-License-Identifier: GPL-3.0-or-later
"""The servo's thread through Python: on the simulated device, on a replayed one, and on one that this test compiles, whose exchange gives
what is not finite, faults and goes away when it is told. No duration is asserted."""
import ctypes
import gc
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest
import warnings

import numpy as np
import voxshell as vxs
from voxshell import hardware

ROOT = pathlib.Path(__file__).resolve().parents[3]
SAMPLES = pathlib.Path(os.environ["VOXSHELL_BUILD"], "samples")
MOCK = r"""
#include "voxshell/device.h"
#include <math.h>
#include <stdatomic.h>
static atomic_int state = VXS_DEVICE_READY, bad, commands, pushed;
static vxs_result arm(void *self) { (void)self; if (state != VXS_DEVICE_READY && state != VXS_DEVICE_ARMED) return VXS_STATE; state = VXS_DEVICE_ARMED; return VXS_OK; }
static vxs_result disarm(void *self) { (void)self; if (state == VXS_DEVICE_GONE) return VXS_LOST; state = VXS_DEVICE_READY; return VXS_OK; }
static void end(void *self) { (void)self; state = VXS_DEVICE_CLOSED; }
static void exchange(void *self, const vxs_device_command *command, vxs_device_state *out, vxs_device_report *report)
{
    static uint64_t sequence;
    (void)self; (void)report;
    double force = command ? fabs(command->wrench.force[0]) : 0;
    commands++;
    pushed = force > 0;
    *out = (vxs_device_state){.sequence = ++sequence, .time_ns = (int64_t)sequence * 1000000, .pose = vxs_pose_identity(), .state = (uint32_t)state};
    out->pose.position[0] = bad ? NAN : 0.0535;
    out->pose.position[1] = 0.04;
}
static const vxs_device_ops ops = {"mock", arm, disarm, end, exchange};
static vxs_device device = {&ops, 0, {.name = "mock"}};
__attribute__((visibility("default"))) vxs_device *mock(int motors) { state = VXS_DEVICE_READY; bad = 0; device.caps.has_motors = (uint32_t)motors; return &device; }
__attribute__((visibility("default"))) void mock_set(int to, int is_bad) { state = to; bad = is_bad; }
__attribute__((visibility("default"))) int mock_state(void) { return state; }
__attribute__((visibility("default"))) int mock_pushed(void) { return pushed; }
__attribute__((visibility("default"))) int mock_commands(void) { return commands; }
"""
QUIET = {"priority": 0, "lock_memory": False}  # a test asks nothing of the machine


def setUpModule():
    global FOLDER, PLAN, C
    FOLDER = pathlib.Path(tempfile.mkdtemp(prefix="voxshell-python-"))
    unittest.addModuleCleanup(shutil.rmtree, FOLDER)
    subprocess.run([os.environ["VOXSHELL"], "convert", SAMPLES / "cup_hold.scene.json", "-o", FOLDER, "-q"], check=True)
    PLAN = vxs.Plan(FOLDER / "cup_hold.plan")
    (FOLDER / "mock.c").write_text(MOCK)
    subprocess.run([os.environ.get("VXS_CC", "cc"), "-std=gnu11", "-shared", "-fPIC", "-I", ROOT / "runtime/include", "-o", FOLDER / "mock.so", FOLDER / "mock.c"], check=True)
    C = ctypes.CDLL(str(FOLDER / "mock.so"))
    C.mock.restype = ctypes.c_void_p


def mock(motors=0):
    return vxs.Device(C.mock(motors))


def servo():
    config = PLAN.config()
    return vxs.Servo(config)


def rate():
    return 1 / PLAN.config().coupling.sample_time


def until(what):
    """A thread of C's goes on meanwhile. The test's own limit is what ends it if it never comes true."""
    event = threading.Event()
    for _ in range(12000):
        if what():
            return
        event.wait(0.005)
    raise AssertionError("did not come true in a minute")


class Loop(unittest.TestCase):
    def test_so_many_ticks(self):
        device = vxs.SimulatedDevice("phantom-premium-1.5", "hand", rate(), (0.075, 0.04, 0))
        loop = vxs.ServoThread(servo(), device, max_ticks=300, **QUIET)
        self.assertFalse(loop.running)
        with loop:
            self.assertTrue(loop.wait())
            self.assertFalse(loop.running)
        status, rows = loop.status(), loop.rows()
        self.assertEqual((status.ticks, status.running), (300, 0))
        self.assertEqual(rows["tick"].tolist(), list(range(300)))
        self.assertEqual(loop.lost, 0)
        for histogram in (status.lateness, status.work):
            self.assertEqual(histogram.counts.sum(), 300)
            self.assertLessEqual(histogram.at_most(0.5), histogram.at_most(1))
            self.assertLessEqual(histogram.at_most(1), histogram.max_ns * 1e-9)
        self.assertIn(b"as configured", status.scheduling_text)
        self.assertTrue(np.all(rows["flags"] & vxs.ServoFlag.OFF))  # nobody armed it
        with self.assertRaisesRegex(RuntimeError, "300 ticks"):
            loop.start()

    def test_the_same_rows_as_a_loop_of_ones_own(self):
        def device():
            return vxs.SimulatedDevice("phantom-premium-1.5", "free", rate(), (0.0535, 0.04, 0))

        own, made, rows = servo(), device(), np.zeros(200, dtype=vxs.ROW)
        made.arm()
        for n in range(200):
            own.tick(made.exchange(own.command), rows, n)
        other = device()
        loop = vxs.ServoThread(servo(), other, max_ticks=200, **QUIET)
        loop.arm()
        with loop:
            loop.wait()
        self.assertEqual(loop.rows().tobytes(), rows.tobytes())
        self.assertEqual(other.exchange(own.command).state, vxs.READY)  # the end disarms

    def test_lost_rows_are_counted_and_told(self):
        loop = vxs.ServoThread(servo(), mock(), ring=16, max_ticks=100, **QUIET)
        with loop:
            loop.wait()
        self.assertEqual(loop.lost, 84)
        with self.assertWarnsRegex(RuntimeWarning, "84 rows lost"):
            rows = loop.rows()
        self.assertEqual(rows["tick"].tolist(), list(range(16)))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assertEqual(len(loop.rows()), 0)

    def test_rows_while_it_runs_are_all_of_them(self):
        loop, parts = vxs.ServoThread(servo(), mock(), ring=4096, max_ticks=400, **QUIET), []
        with loop:
            while loop.running:
                parts.append(loop.rows())
        parts.append(loop.rows())
        ticks = np.concatenate(parts)["tick"]
        self.assertEqual(len(ticks) + loop.lost, 400)
        self.assertTrue(np.all(np.diff(ticks.astype(np.int64)) > 0))

    def test_arming_while_it_runs(self):
        device = mock()
        with vxs.ServoThread(servo(), device, **QUIET) as loop:
            until(lambda: loop.status().ticks > 3)
            self.assertEqual(C.mock_state(), vxs.READY)
            loop.arm()
            self.assertTrue(loop.running)
            before = loop.status().ticks
            until(lambda: loop.status().ticks > before + 3)
            self.assertEqual(C.mock_state(), vxs.ARMED)
            loop.disarm()
            self.assertEqual(C.mock_state(), vxs.READY)
            ticks = loop.status().ticks
        self.assertGreaterEqual(loop.status().ticks, ticks)  # of all loops since the first
        self.assertEqual(C.mock_state(), vxs.READY)

    def test_what_the_thread_has_is_nobody_elses(self):
        device, own = mock(), servo()
        with vxs.ServoThread(own, device, **QUIET) as loop:
            for touch in (device.arm, device.disarm, device.close, lambda: device.exchange(own.command), lambda: own.tick(device.state), own.clear):
                with self.assertRaisesRegex(RuntimeError, "thread's until"):
                    touch()
            with self.assertRaisesRegex(RuntimeError, "runs already"):
                loop.start()
            with self.assertRaisesRegex(RuntimeError, "thread's until"):
                vxs.ServoThread(servo(), device, **QUIET).start()
        device.exchange(own.command)
        device.close()
        device.close()
        with self.assertRaisesRegex(RuntimeError, "closed"):
            device.arm()

    def test_a_dropped_loop_stops(self):
        loop = vxs.ServoThread(servo(), mock(), **QUIET)
        loop.start()
        until(lambda: loop.status().ticks > 3)
        end = loop._stop
        del loop
        gc.collect()
        self.assertFalse(end.alive)
        commands = C.mock_commands()
        threading.Event().wait(0.02)
        self.assertEqual(C.mock_commands(), commands)

    def test_an_error_in_the_block_stops_it(self):
        device = mock()
        with self.assertRaisesRegex(KeyError, "mine"):
            with vxs.ServoThread(servo(), device, **QUIET) as loop:
                loop.arm()
                raise KeyError("mine")
        self.assertFalse(loop.running)
        self.assertEqual(C.mock_state(), vxs.READY)

    def test_a_program_that_just_ends(self):
        code = ("import os, sys, voxshell as vxs; p = vxs.Plan(sys.argv[1]); s = vxs.Servo(p.config())\n"
                "l = vxs.ServoThread(s, vxs.SimulatedDevice(start=(0.075, 0.04, 0)), priority=0, lock_memory=False); l.start(); print('ends')")
        done = subprocess.run([sys.executable, "-c", code, PLAN.path], capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "ends\n", ""))

    def test_a_forked_child_ends_without_it(self):
        """It has the loop's memory, and not its thread: ending must not wait for that."""
        code = ("import os, sys, voxshell as vxs; p = vxs.Plan(sys.argv[1]); s = vxs.Servo(p.config())\n"
                "l = vxs.ServoThread(s, vxs.SimulatedDevice(start=(0.075, 0.04, 0)), priority=0, lock_memory=False); l.start(); child = os.fork()\n"
                "if child: print(os.waitpid(child, 0)[1], l.running); l.stop()")
        done = subprocess.run([sys.executable, "-c", code, PLAN.path], capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "0 True\n", ""))


class Faults(unittest.TestCase):
    def test_not_finite(self):
        device = mock()
        with vxs.ServoThread(servo(), device, **QUIET) as loop:
            loop.arm()
            until(lambda: loop.status().ticks > 3)
            loop.check()
            C.mock_set(vxs.ARMED, 1)
            with self.assertRaisesRegex(vxs.ServoFault, "FAULT") as raised:
                loop.wait()
            self.assertTrue(raised.exception.flags & vxs.ServoFlag.FAULT)
            self.assertTrue(loop.running)  # and gives nothing
            until(lambda: not C.mock_pushed())
            C.mock_set(vxs.ARMED, 0)
            with self.assertRaises(vxs.ServoFault):  # latched
                loop.check()
            loop.clear()
            before = loop.status().ticks
            until(lambda: loop.status().ticks > before + 3)
            loop.check()
            self.assertTrue(loop.status().seen_flags & vxs.ServoFlag.FAULT)
        rows = loop.rows()
        self.assertTrue(np.all(rows["command"]["force"][rows["flags"] & vxs.ServoFlag.FAULT != 0] == 0))

    def test_device_in_fault_and_gone(self):
        with vxs.ServoThread(servo(), mock(), **QUIET) as loop:
            for state in (vxs.FAULT, vxs.GONE):
                C.mock_set(state, 0)
                with self.assertRaisesRegex(vxs.ServoFault, "device is lost") as raised:
                    loop.wait()
                self.assertFalse(raised.exception.flags & vxs.ServoFlag.FAULT)
                with self.assertRaisesRegex(vxs.Error, "state"):
                    loop.arm()
                self.assertTrue(loop.running)
                C.mock_set(vxs.READY, 0)
                before = loop.status().ticks
                until(lambda: loop.status().ticks > before + 3)
                loop.check()

    def test_refusals(self):
        config = PLAN.config()
        config.effects, config.effect_count = None, 0
        with self.assertRaises(vxs.Error) as raised:
            vxs.ServoThread(vxs.Servo(config), mock(motors=1), **QUIET).start()
        self.assertEqual(raised.exception.result, "VXS_UNGUARDED")
        with self.assertRaisesRegex(ValueError, "rate 500 Hz: the servo was made for"):
            vxs.ServoThread(servo(), mock(), rate=500)
        with self.assertRaises(vxs.Error) as raised:
            vxs.ServoThread(servo(), mock(), priority=100).start()
        self.assertEqual(raised.exception.result, "VXS_PARAM")


class Devices(unittest.TestCase):
    def test_replay(self):
        rows = np.zeros(3, dtype=vxs.REPLAY_ROW)
        rows["time"], rows["pose"]["orientation"] = (0, 0.05, 0.1), (1, 0, 0, 0)
        rows["pose"]["position"] = [(0.075, 0.04, 0), (0.075, 0.04, 0), (0.053, 0.04, 0)]
        with vxs.ServoThread(servo(), vxs.ReplayDevice(rows, rate()), max_ticks=150, **QUIET) as loop:
            loop.wait()
        went = loop.rows()
        self.assertAlmostEqual(went["pose"]["position"][0, 0], 0.075, places=12)
        self.assertAlmostEqual(went["pose"]["position"][-1, 0], 0.053, places=12)
        self.assertEqual(went["points"][0], 0)
        self.assertGreater(went["points"][-1], 0)

    def test_a_file_of_replay(self):
        path = FOLDER / "hand.csv"
        path.write_text("t_s,x_m,y_m,z_m\n0,0.1,0,0\n1,0.2,0,0\n")
        self.assertEqual(vxs.ReplayDevice(path).exchange(vxs.DeviceCommand()).pose.position[0], 0.1)
        path.write_text("t_s,x_m,y_m,z_m\n0,0.1,0,0\n1,nan,0,0\n")
        with self.assertRaisesRegex(vxs.Error, "hand.csv, line 3"):
            vxs.ReplayDevice(path)

    def test_hardware_that_is_not_there(self):
        self.assertIn("hvlink", vxs.hardware_names())
        with self.assertRaisesRegex(ValueError, "there are .*hvlink"):
            vxs.HardwareDevice("omega")
        with self.assertRaisesRegex(ValueError, "baud: a device's config has address|baud: a device's config has is_in_place"):
            vxs.HardwareDevice("hvlink", baud=9600)
        with self.assertRaisesRegex(vxs.Error, "hvlink at .*none: ") as raised:
            vxs.HardwareDevice("hvlink", FOLDER / "none")
        self.assertEqual(raised.exception.result, "VXS_NO_DEVICE")

    def test_caps(self):
        device = vxs.SimulatedDevice("omega-3")
        self.assertEqual((device.caps.name, device.caps.has_motors), (b"omega-3", 0))
        self.assertEqual(device.caps.peak_force, device.config.profile.peak_force)
        self.assertEqual(hardware.HardwareConfig.default().rate_hz, 1000)


if __name__ == "__main__":
    unittest.main()
