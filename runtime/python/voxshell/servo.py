# SPDX-License-Identifier: MIT
"""One tick: device state in, command out (voxshell/servo.h, voxshell/coupling.h)."""
import ctypes
import enum

import numpy as np

from .contact import ContactConfig
from .device import DeviceCommand
from .library import Memory, Struct, load, need
from .pose import Pose, Wrench

COUPLINGS = {"none": 1, "pt2": 2, "spring-damper": 3, "quasi-static": 4}


class ServoFlag(enum.IntFlag):
    """Of a tick (VXS_SERVO_*); the low byte is ContactFlag's."""

    OFF = 1 << 8                # the device is not ARMED: zero force
    RAMPING = 1 << 9            # soft-start is not over
    START_IN_CONTACT = 1 << 10  # zero force until the object was free once
    SLEWED = 1 << 11
    SATURATED = 1 << 12         # the clamp acted
    DEVICE_STALE = 1 << 13      # no new measurement
    MISSED = 1 << 14
    DEVICE_LOST = 1 << 15
    FAULT = 1 << 16             # latched zero force until Servo.clear()
    TELEPORT = 1 << 17          # moved faster than max_speed
    DAMPED = 1 << 18            # the passivity controller acted


class CouplingConfig(Struct):
    """kind (COUPLINGS), sample_time [s]; pt2: omega0 [rad/s], damping, gain; others: stiffness [N/m], radius [m], mass [kg]."""

    C_NAME = "vxs_coupling_config"
    _fields_ = [("struct_size", ctypes.c_uint32), ("kind", ctypes.c_uint32), ("sample_time", ctypes.c_double), ("omega0", ctypes.c_double),
                ("damping", ctypes.c_double), ("gain", ctypes.c_double), ("prewarp", ctypes.c_uint32), ("evaluations", ctypes.c_uint32),
                ("stiffness", ctypes.c_double), ("radius", ctypes.c_double), ("mass", ctypes.c_double), ("own", ctypes.c_void_p)]


class ServoConfig(Struct):
    """contact (ContactConfig), coupling (CouplingConfig), max_force [N], max_torque [N m], max_speed [m/s], scale, mount and grip
    (Pose). What it points to comes from a plan (Plan.config()) or set_scene()."""

    C_NAME = "vxs_servo_config"
    _fields_ = [("struct_size", ctypes.c_uint32), ("static_count", ctypes.c_uint32), ("statics", ctypes.c_void_p), ("shell", ctypes.c_void_p),
                ("mount", Pose), ("grip", Pose), ("scale", ctypes.c_double), ("contact", ContactConfig), ("coupling", CouplingConfig),
                *[(name, ctypes.c_double) for name in ("max_force", "max_torque", "max_speed")], ("effects", ctypes.c_void_p),
                ("effect_count", ctypes.c_uint32), ("reserved", ctypes.c_uint32), ("hold_time", ctypes.c_double), ("decay_time", ctypes.c_double)]

    def set_scene(self, shell, statics):
        """What moves (Pointshell) and what stands (Statics)."""
        self.borrowed = (shell, statics)
        self.shell, self.statics, self.static_count = ctypes.addressof(shell.c), ctypes.addressof(statics.array), len(statics)


class ServoTrace(Struct):
    C_NAME = "vxs_servo_trace"
    _fields_ = [("tick", ctypes.c_uint64), ("time_ns", ctypes.c_int64), ("pose", Pose), ("body", Pose), ("collision", Wrench),
                ("output", Wrench), ("command", Wrench),
                *[(name, ctypes.c_double) for name in ("depth", "gain", "energy", "damping")],
                *[(name, ctypes.c_uint32) for name in ("points", "deep_points", "patches", "level", "probed", "flags")]]


ROW = np.dtype(ServoTrace)
"""One tick: tick, time_ns, pose and body (position [m], orientation w x y z), collision, output and command (force [N], torque
[N m]), depth [m], gain, energy [J], damping [N s/m], points, deep_points, patches, level, probed, flags."""


class Servo:
    """A servo made from a config. Raises Error as vxs_servo_init(). One thread at a time.

    Nothing here waits or looks at a clock: who calls tick() decides what time it is. Python is no real-time language: on the wall
    clock, and on hardware, a ServoThread runs it.
    """

    def __init__(self, config):
        self.config = config  # and what it has borrowed
        self._memory = Memory(load().vxs_servo_memory(ctypes.byref(config)))
        self._servo = ctypes.c_void_p()
        need(load().vxs_servo_init(self._memory.address, self._memory.size, ctypes.byref(config), ctypes.byref(self._servo)), "servo")
        self.address = self._servo.value
        self.is_taken = False  # by a ServoThread
        self.command = DeviceCommand()

    def need_free(self):
        """Raises RuntimeError where a loop has it."""
        if self.is_taken:
            raise RuntimeError("the servo is its thread's until that is stopped")

    def tick(self, state, rows=None, n=0):
        """One sample: DeviceState in, flags out (ServoFlag | ContactFlag); self.command is what the device is to be told, and
        rows[n] (an array of ROW), if given, what was felt."""
        self.need_free()
        row = None if rows is None else rows.ctypes.data + rows.strides[0] * range(len(rows))[n]
        return load().vxs_servo_tick(self._servo, ctypes.byref(state), ctypes.byref(self.command), row)

    def clear(self):
        """Ends a FAULT."""
        self.need_free()
        load().vxs_servo_clear(self._servo)
