# SPDX-License-Identifier: MIT
"""A compiled scene, and its run on a simulated device (voxshell/plan.h, formats/plan.md)."""
import bisect
import ctypes
import math
import os

import numpy as np

from .asset import Asset, AssetView
from .contact import Contact
from .device import SimulatedDevice
from .library import Error, Memory, Struct, load, need
from .pointshell import Pointshell
from .pose import Pose
from .servo import ROW, Servo, ServoConfig
from .voxmap import Voxmap


class PlanInfo(Struct):
    C_NAME = "vxs_plan_info"
    _fields_ = [("rate", ctypes.c_double), *[(name, ctypes.c_uint32) for name in ("law", "field", "weighting", "flags")],
                *[(name, ctypes.c_double) for name in ("stiffness", "most_stiffness", "budget")],
                *[(name, ctypes.c_uint32) for name in ("coupling", "prewarp", "evaluations", "reserved")],
                *[(name, ctypes.c_double) for name in ("omega0", "damping", "gain", "coupling_stiffness", "radius", "mass", "max_force",
                                                       "max_torque", "max_speed", "hold_time", "decay_time", "scale")],
                ("mount_position", ctypes.c_double * 3), ("mount_orientation", ctypes.c_double * 4),
                ("grip_position", ctypes.c_double * 3), ("grip_orientation", ctypes.c_double * 4), ("device", ctypes.c_char * 48),
                ("arm", ctypes.c_char * 16), ("pad", ctypes.c_uint8 * 48)]


class PlanAsset(Struct):
    C_NAME = "vxs_plan_asset"
    _fields_ = [("role", ctypes.c_uint32), ("reserved", ctypes.c_uint32), ("position", ctypes.c_double * 3),
                ("orientation", ctypes.c_double * 4), ("content_hash", ctypes.c_uint8 * 32), ("name", ctypes.c_char * 256),
                ("pad", ctypes.c_uint8 * 32)]


class PlanEffect(Struct):
    C_NAME = "vxs_plan_effect"
    _fields_ = [("kind", ctypes.c_char * 32), ("constant_count", ctypes.c_uint32), ("reserved", ctypes.c_uint32),
                ("constants", ctypes.c_double * 24)]


class PlanKeyframe(Struct):
    C_NAME = "vxs_plan_keyframe"
    _fields_ = [("time", ctypes.c_double), ("position", ctypes.c_double * 3), ("orientation", ctypes.c_double * 4), ("move", ctypes.c_uint32),
                ("reserved", ctypes.c_uint32), ("turn_about", ctypes.c_double * 3), ("turn_axis", ctypes.c_double * 3),
                ("turn_angle", ctypes.c_double)]


class PlanMotion(Struct):
    C_NAME = "vxs_plan_motion"
    _fields_ = [("time", ctypes.c_double), ("position", ctypes.c_double * 3), ("orientation", ctypes.c_double * 4), ("asset", ctypes.c_uint32),
                ("reserved", ctypes.c_uint32)]


class PlanView(Struct):
    C_NAME = "vxs_plan"
    _fields_ = [("info", ctypes.POINTER(PlanInfo)), ("assets", ctypes.POINTER(PlanAsset)), ("asset_count", ctypes.c_uint32),
                ("effect_count", ctypes.c_uint32), ("effects", ctypes.POINTER(PlanEffect)), ("hand", ctypes.c_void_p),
                ("moves", ctypes.c_void_p), ("hand_count", ctypes.c_uint32), ("move_count", ctypes.c_uint32)]


class PlanIssue(Struct):
    C_NAME = "vxs_plan_issue"
    _fields_ = [("entry", ctypes.c_uint32), ("is_effect", ctypes.c_uint32), ("expected", ctypes.c_uint8 * 32), ("found", ctypes.c_uint8 * 32),
                ("text", ctypes.c_char_p)]


class EffectConstant(Struct):
    C_NAME = "vxs_effect_constant"
    _fields_ = [("name", ctypes.c_char_p), ("unit", ctypes.c_char_p), ("standard", ctypes.c_double), ("least", ctypes.c_double),
                ("most", ctypes.c_double)]


class Plan(Asset):
    """A .plan: what a scene says, compiled for a device.

    rate, device, arm      ticks a second [Hz]; names
    assets                 names of the files that it is for, beside it: statics, then what moves
    effects                {kind: {constant: value}} in order of execution
    hand                   (K,) of time [s], position [m], orientation (w x y z), ...: keyframes; a view
    moves                  (M,) of time, position, orientation, asset: keyframes of statics that move; a view
    info                   the rest (PlanInfo): law, stiffness, max_force ...
    """

    KIND = 3

    def _read(self):
        self.c = PlanView()
        need(load().vxs_plan_open(ctypes.byref(self.view), ctypes.byref(self.c)), self.path)
        self.info = PlanInfo.from_buffer_copy(self.section("PLAN"))
        self.rate, self.device, self.arm = self.info.rate, self.info.device.decode(), self.info.arm.decode()
        self.assets = [self.c.assets[n].name.decode() for n in range(self.c.asset_count)]
        self.effects = dict(self._effect(self.c.effects[n]) for n in range(self.c.effect_count))
        self.hand = self._keyframes("HAND", PlanKeyframe)
        self.moves = self._keyframes("MOVE", PlanMotion)
        self._times = self.hand["time"].tolist()

    def _keyframes(self, section, kind):
        return self.section(section, np.dtype(kind)) if section in self._table else np.zeros(0, dtype=np.dtype(kind))

    @staticmethod
    def _effect(effect):
        count = ctypes.c_uint32()
        address = load().vxs_effect_constants(load().vxs_effect_kind_named(effect.kind), ctypes.byref(count))
        known = (EffectConstant * count.value).from_address(address) if address else []
        names = [known[n].name.decode() if n < len(known) else str(n) for n in range(effect.constant_count)]
        return effect.kind.decode(), dict(zip(names, effect.constants))

    def config(self, folder=None):
        """The servo's config, to be changed as an experiment wants it, with the plan's assets opened from its own folder (or
        another one). Raises Error: VXS_PLAN for an asset that is another one than the plan was made for."""
        folder = os.path.dirname(self.path) if folder is None else os.fspath(folder)
        kinds = [Voxmap] * (len(self.assets) - 1) + [Pointshell]
        opened = [kind(os.path.join(folder, name)) for kind, name in zip(kinds, self.assets)]
        views, room = (AssetView * len(opened))(*[asset.view for asset in opened]), Memory(load().vxs_plan_memory(ctypes.byref(self.c)))
        config, issue = ServoConfig(), PlanIssue()
        code = load().vxs_plan_load(ctypes.byref(self.c), views, room.address, room.size, ctypes.byref(config), ctypes.byref(issue))
        if code:
            entry = list(self.effects)[issue.entry] if issue.is_effect else os.path.join(folder, self.assets[issue.entry])
            raise Error(code, f"{self.path}: {entry}", detail=(issue.text or b"").decode())
        config.borrowed = (self, opened, views, room)
        if self.info.budget > 0:  # [s], of all evaluations in a tick; how many points it buys is this machine's affair
            evaluations = config.coupling.evaluations if config.coupling.kind == 4 else 1
            cost = Contact(opened[-1], opened[0]).point_cost()
            config.contact.most_points = int(min(max(self.info.budget / evaluations / cost, 1), 4e9))
        return config

    def hand_at(self, t):
        """Where the hand wants to be at t [s]: Pose. Raises ValueError for a plan without a hand."""
        if not len(self.hand):
            raise ValueError(f"{self.path}: has no hand: nothing would move")
        after = bisect.bisect_right(self._times, t)
        if after in (0, len(self.hand)):
            frame = self.hand[max(after - 1, 0)]
            return Pose(tuple(frame["position"].tolist()), tuple(frame["orientation"].tolist()))
        begin, end = self.hand[after - 1], self.hand[after]
        share = (t - self._times[after - 1]) / (self._times[after] - self._times[after - 1])
        from_, to = begin["position"].tolist(), end["position"].tolist()
        if end["move"]:
            position = _turned(end, from_, share)
        else:
            position = [a + share * (b - a) for a, b in zip(from_, to)]
        # Normalised linear interpolation the short way round, x y z w.
        (aw, ax, ay, az), (bw, bx, by, bz) = begin["orientation"].tolist(), end["orientation"].tolist()
        sign = -1 if ax * bx + ay * by + az * bz + aw * bw < 0 else 1
        x, y, z, w = (a + share * (sign * b - a) for a, b in ((ax, bx), (ay, by), (az, bz), (aw, bw)))
        length = math.sqrt(x * x + y * y + z * z + w * w)
        return Pose(tuple(position), (w / length, x / length, y / length, z / length))

    def simulate(self, config=None, seconds=None, device=None, arm=None, **simulated):
        """Runs the scene on virtual time: an array of ROW, one a tick; the same bits on every run and machine.

        config     of config(), changed as you like; None: as the plan says
        seconds    None: to the hand's last keyframe
        device, arm, and noise, loss, delay, seed as SimulatedDevice has them; None: the plan's
        """
        name = self.device if device is None else device
        if not name.startswith("sim:") or "," in name:
            raise ValueError(f"device '{name}': give a simulated one, as 'sim:omega-3', and its noise, loss, delay and seed by their names")
        device = SimulatedDevice(name[4:], self.arm if arm is None else arm, self.rate, _numbers(self.hand_at(0.0)), **simulated)
        servo = Servo(self.config() if config is None else config)
        seconds = self._times[-1] if seconds is None else seconds
        rows = np.zeros(max(int(math.floor(seconds * self.rate + 0.5)), 1), dtype=ROW)
        device.arm()
        for n in range(len(rows)):
            device.hand(self.hand_at(n / self.rate))
            servo.tick(device.exchange(servo.command), rows, n)
        device.disarm()
        return rows


def _numbers(pose):
    return [*pose.position, *pose.orientation]


def _turned(frame, from_, share):
    """The position before, turned about the arc's axis by a share of its angle."""
    about, axis, half = frame["turn_about"].tolist(), frame["turn_axis"].tolist(), frame["turn_angle"].item() * share / 2
    s, w = math.sin(half), math.cos(half)
    u, v = [a * s for a in axis], [a - b for a, b in zip(from_, about)]
    t = _cross(u, v)
    r = _cross(u, t)
    return [about[n] + (v[n] + 2 * (w * t[n] + r[n])) for n in range(3)]


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
