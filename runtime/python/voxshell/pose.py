# SPDX-License-Identifier: MIT
"""Where a body is, and what acts on it (voxshell/pose.h). SI units; quaternions are w x y z and need not have length 1.

In arrays a pose is seven numbers: x y z [m], then w x y z.
"""
import ctypes

import numpy as np

from .library import Struct


class Pose(Struct):
    C_NAME = "vxs_pose"
    _fields_ = [("position", ctypes.c_double * 3), ("orientation", ctypes.c_double * 4)]


class Wrench(Struct):
    C_NAME = "vxs_wrench"
    _fields_ = [("force", ctypes.c_double * 3), ("torque", ctypes.c_double * 3)]


def as_poses(poses):
    """(..., 3) positions or (..., 7) poses -> (..., 7) float64 in one piece. Raises ValueError for another shape."""
    poses = np.asarray(poses, dtype=np.float64)
    if poses.ndim and poses.shape[-1] == 3:
        poses = np.concatenate([poses, np.broadcast_to([1.0, 0, 0, 0], poses.shape[:-1] + (4,))], axis=-1)
    if not poses.ndim or poses.shape[-1] != 7:
        raise ValueError(f"a pose is 3 or 7 numbers (x y z, w x y z), not an array of shape {poses.shape}")
    return np.ascontiguousarray(poses)


def as_pose(pose):
    """Three or seven numbers -> Pose."""
    return Pose.from_buffer_copy(as_poses(pose).reshape(7))
