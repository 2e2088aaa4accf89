# SPDX-License-Identifier: MIT
"""The moving object: points on its surface (voxshell/pointshell.h, formats/pointshell.md)."""
import ctypes

import numpy as np

from .asset import Asset
from .library import Struct, load, need


class PointshellView(Struct):
    C_NAME = "vxs_pointshell"
    _fields_ = [("voxel", ctypes.c_double), ("kind", ctypes.c_uint32), ("point_count", ctypes.c_uint32),
                ("padded_count", ctypes.c_uint32), ("cluster_count", ctypes.c_uint32),
                *[(name, ctypes.c_void_p) for name in ("x", "y", "z", "nx", "ny", "nz", "area", "clusters")],
                ("center", ctypes.c_double * 3), ("radius", ctypes.c_double), ("total_area", ctypes.c_double),
                ("gap_max", ctypes.c_double), ("surface_error", ctypes.c_double)]


class Pointshell(Asset):
    """A .pointshell.

    positions   (N, 3) float32 [m], in the part's own frame; a view of the file (strided: x, y and z lie apart there)
    normals     (N, 3) float32, unit, into the object; a view
    areas       (N,) float32 [m^2], or None in a shell that was made without; a view
    clusters    (M,) of center [m], radius [m], first, count; a view
    voxel       edge of the cells that it was made with [m]
    center, radius, area, gap_max, surface_error    of all points [m], [m^2]
    """

    KIND = 2

    def _read(self):
        self.c = PointshellView()
        need(load().vxs_pointshell_open(ctypes.byref(self.view), ctypes.byref(self.c)), self.path)
        self.voxel, self.radius, self.area = self.c.voxel, self.c.radius, self.c.total_area
        self.center = tuple(self.c.center)
        self.gap_max, self.surface_error = self.c.gap_max, self.c.surface_error
        self.kind = {1: "exact", 2: "naive"}[self.c.kind]
        self.positions, self.normals = self._three("POSX"), self._three("NRMX")
        self.areas = self.section("AREA", "<f4")[:len(self)] if self.c.area else None
        self.clusters = self.section("CLUS", [("center", "<f4", 3), ("radius", "<f4"), ("first", "<u4"), ("count", "<u4"), ("reserved", "<u4", 2)])

    def _three(self, first):
        """Three sections that follow each other without a gap (formats/container.md, C203), as the columns of one array."""
        start, padded = int(self._table[first]["offset"]), self.c.padded_count
        return np.ndarray((len(self), 3), "<f4", self.bytes, offset=start, strides=(4, 4 * padded))

    def __len__(self):
        return self.c.point_count
