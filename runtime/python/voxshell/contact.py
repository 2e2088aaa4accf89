# SPDX-License-Identifier: MIT
"""Force and torque on a moving shell in static maps (voxshell/contact.h has the formulas and their source)."""
import ctypes
import enum

import numpy as np

from .library import Memory, Struct, load, need
from .pose import Pose, Wrench, as_pose, as_poses

LAWS = {"original": 1, "average": 2, "gradient": 3, "patch": 4}
FIELDS = {"surface": 1, "layers": 2, "distance": 3}
WEIGHTINGS = {"count": 1, "count-capped": 2, "area": 3}


class ContactFlag(enum.IntFlag):
    """Of a result (VXS_CONTACT_*)."""

    DEEP = 1 << 0            # a point is deeper than the field reaches
    MEAN_CANCELLED = 1 << 1  # average: opposed normals, evaluated as patch
    OUT_OF_MAP = 1 << 2      # the shell is beyond every map's box
    OVERFLOW = 1 << 3        # more hits than points
    INVALID = 1 << 4         # pose or config refused, or not finite: zero wrench
    WRONG_SKIP = 1 << 5      # never, in a map that was checked
    OVER_BUDGET = 1 << 6     # more than most_points were looked at
    SOFTENED = 1 << 7        # most_stiffness acted


class ContactConfig(Struct):
    """law, field, weighting: numbers (LAWS, FIELDS, WEIGHTINGS); stiffness [N/m] per point, with area [N/m^3]; most_stiffness
    [N/m], 0: no bound; reference [m], in the shell's frame: what torque is about."""

    C_NAME = "vxs_contact_config"
    _fields_ = [("struct_size", ctypes.c_uint32), ("law", ctypes.c_uint32), ("field", ctypes.c_uint32), ("weighting", ctypes.c_uint32),
                ("most_points", ctypes.c_uint32), ("stiffness", ctypes.c_double), ("most_stiffness", ctypes.c_double),
                ("reference", ctypes.c_double * 3), ("loads", ctypes.c_void_p)]


class ContactResult(Struct):
    C_NAME = "vxs_contact_result"
    _fields_ = [("wrench", Wrench), ("normal", ctypes.c_double * 3), ("depth", ctypes.c_double), ("stiffness", ctypes.c_double),
                ("points", ctypes.c_uint32), ("deep_points", ctypes.c_uint32), ("patches", ctypes.c_uint32), ("level", ctypes.c_uint32),
                ("probed", ctypes.c_uint32), ("flags", ctypes.c_uint32)]


class ContactStatic(Struct):
    C_NAME = "vxs_contact_static"
    _fields_ = [("map", ctypes.c_void_p), ("pose", ctypes.c_void_p)]


RESULT = np.dtype(ContactResult)  #: one result: wrench.force [N], wrench.torque [N m], normal, depth [m], points, flags ...


class Statics:
    """Maps and where they stand, as the library wants them: Voxmap, or (Voxmap, pose), or a list of these."""

    def __init__(self, maps):
        maps = maps if isinstance(maps, list) else [maps]
        self.maps, self.poses = [], []
        for entry in maps:
            map_, pose = entry if isinstance(entry, tuple) else (entry, (0, 0, 0))
            self.maps.append(map_)
            self.poses.append(as_pose(pose))
        self.array = (ContactStatic * len(maps))(
            *[ContactStatic(ctypes.addressof(map_.c), ctypes.addressof(pose)) for map_, pose in zip(self.maps, self.poses)])

    def __len__(self):
        return len(self.maps)


class Contact:
    """One shell's contact with static maps.

    shell        Pointshell
    statics      a Voxmap, a pair (Voxmap, pose) or a list of these; a pose is 3 or 7 numbers (pose.py)
    law          original, average, patch, gradient     (contact.h; the default is the paper's)
    field        surface, layers, distance: the last two need their channel in every map
    weighting    count (stiffness in N/m per point), count-capped, area (N/m^3)
    stiffness    > 0
    most_stiffness   bound on the contact as a whole [N/m], 0: none
    reference    what torque is about, in the shell's frame [m]

    Raises Error as vxs_contact_config_check() and for a map that lacks the field's channel (VXS_CHANNEL), ValueError for a
    name that is none. One thread at a time.
    """

    def __init__(self, shell, statics, law="average", field="surface", weighting="count", stiffness=1000.0, most_stiffness=0.0,
                 reference=(0.0, 0.0, 0.0)):
        self.shell, self.statics = shell, Statics(statics)
        self.config = ContactConfig.default()
        self.config.law, self.config.field = named(LAWS, "law", law), named(FIELDS, "field", field)
        self.config.weighting = named(WEIGHTINGS, "weighting", weighting)
        self.config.stiffness, self.config.most_stiffness = stiffness, most_stiffness
        self.config.reference[:] = reference
        need(load().vxs_contact_config_check(ctypes.byref(self.config)), "contact")
        for map_ in self.statics.maps:
            if not load().vxs_contact_has_field(ctypes.byref(map_.c), self.config.field):
                need(-71, map_.path)  # VXS_CHANNEL
        self._memory = Memory(load().vxs_contact_memory(ctypes.byref(shell.c), len(self.statics)))
        self._contact = ctypes.c_void_p()
        need(load().vxs_contact_init(self._memory.address, self._memory.size, ctypes.byref(shell.c), len(self.statics),
                                     ctypes.byref(self._contact)), "contact")

    def evaluate(self, poses):
        """Results at poses (..., 7), or at positions (..., 3) without a turn: an array of RESULT of shape (...).

        Never fails: a pose that is not finite gets a zero wrench and ContactFlag.INVALID."""
        poses = as_poses(poses)
        results = np.zeros(poses.shape[:-1], dtype=RESULT)
        evaluate, statics, config = load().vxs_contact_evaluate, ctypes.addressof(self.statics.array), ctypes.addressof(self.config)
        for n in range(results.size):
            evaluate(self._contact, statics, len(self.statics), poses.ctypes.data + 56 * n, config,
                     results.ctypes.data + RESULT.itemsize * n)
        return results

    def point_cost(self):
        """What a point costs at most on this machine [s]; takes some ms."""
        return load().vxs_contact_point_cost(self._contact)


def named(names, what, name):
    if name not in names:
        raise ValueError(f"{what} '{name}': there are {', '.join(names)}")
    return names[name]


assert ctypes.sizeof(Pose) == 56
