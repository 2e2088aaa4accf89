# SPDX-License-Identifier: MIT
"""The static scene: cells (voxshell/voxmap.h, formats/voxmap.md)."""
import ctypes

import numpy as np

from .asset import Asset
from .library import Struct, load, need

FREE, SURFACE, INTERIOR = 0, 1, 2
_BLOCK = 1 << 12  # bricks that are unpacked at once


class VoxmapView(Struct):
    C_NAME = "vxs_voxmap"
    _fields_ = [("voxel", ctypes.c_double), ("origin_cell", ctypes.c_int64 * 3), ("cells", ctypes.c_uint32 * 3),
                ("root_dims", ctypes.c_uint32 * 3),
                *[(name, ctypes.c_void_p) for name in ("root", "chunks", "bricks", "layers", "distances", "clearance_index",
                                                       "clearance", "clearance_chunks", "planes")],
                ("chunk_count", ctypes.c_uint64), ("brick_count", ctypes.c_uint64), ("clearance_count", ctypes.c_uint64),
                ("surface_cells", ctypes.c_uint64), ("interior_cells", ctypes.c_uint64),
                ("bbox_min", ctypes.c_int64 * 3), ("bbox_max", ctypes.c_int64 * 3), ("layer_count", ctypes.c_uint32),
                ("flags", ctypes.c_uint32), ("distance_step", ctypes.c_double), ("distance_band", ctypes.c_double),
                ("distance_error", ctypes.c_double)]


class Voxmap(Asset):
    """A .voxmap. Cell (i, j, k) is the box from voxel * (i, j, k) to voxel * (i + 1, j + 1, k + 1) [m].

    voxel            edge of a cell [m]
    bbox             (2, 3) int64: first and last cell that is not free, on each axis
    surface_cells, interior_cells    how many
    root, chunks, bricks, layers, distances    the sections as formats/voxmap.md has them, views of the file; the last two None
                     where the map has not got the channel
    state(cells), distance(cells), layer(cells)   look-ups, for any array of cells
    states(low, high)   a box of cells as a dense array
    surface()        the surface cells as a list
    """

    KIND = 1

    def _read(self):
        self.c = VoxmapView()
        need(load().vxs_voxmap_open(ctypes.byref(self.view), ctypes.byref(self.c)), self.path)
        self.voxel = self.c.voxel
        self.surface_cells, self.interior_cells = self.c.surface_cells, self.c.interior_cells
        self.bbox = np.array([list(self.c.bbox_min), list(self.c.bbox_max)])
        self.distance_step, self.distance_band, self.distance_error = self.c.distance_step, self.c.distance_band, self.c.distance_error
        self.root = self.section("ROOT", "<u4", tuple(self.c.root_dims))
        self.chunks = self.section("CHNK", "<u4", (-1, 8, 8, 8))
        self.bricks = self.section("BRIK", "<u8", (-1, 16))
        self.layers = self.section("LAYR", "i1", (-1, 8, 8, 8)) if self.c.layers else None
        self.distances = self.section("DIST", "<i2", (-1, 8, 8, 8)) if self.c.distances else None

    def _find(self, cells):
        """Where cells (..., 3) are kept: brick or -1, the cell's number in it, and the state where there is no brick."""
        cells = np.asarray(cells, dtype=np.int64)
        if not cells.ndim or cells.shape[-1] != 3:
            raise ValueError(f"cells are three numbers each, not an array of shape {cells.shape}")
        at = cells - np.array(list(self.c.origin_cell))
        inside = ((at >= 0) & (at < np.array(list(self.c.cells)))).all(axis=-1)
        at = np.where(inside[..., None], at, 0)
        entry = np.where(inside, self.root[tuple(np.moveaxis(at >> 6, -1, 0))], FREE)
        i, j, k = np.moveaxis(at >> 3 & 7, -1, 0)
        entry = np.where(entry >= 4, self.chunks[np.maximum(entry, 4).astype(np.int64) - 4, i, j, k], entry)
        i, j, k = np.moveaxis(at & 7, -1, 0)
        return np.where(entry >= 4, entry.astype(np.int64) - 4, -1), i << 6 | j << 3 | k, entry

    def state(self, cells):
        """FREE, SURFACE or INTERIOR of cells (..., 3): uint8 of shape (...)."""
        brick, number, entry = self._find(cells)
        word = self.bricks[np.maximum(brick, 0), number >> 5]
        bits = word >> ((number & 31) << 1).astype(np.uint64) & np.uint64(3)
        return np.where(brick >= 0, bits, entry).astype(np.uint8)

    def distance(self, cells):
        """Signed distance at the centres of cells (..., 3) [m], negative inside, right to distance_error; beyond the band it
        stays at distance_band, or minus that inside. Raises ValueError for a map without the channel."""
        if self.distances is None:
            raise ValueError(f"{self.path}: has no distances: voxshell convert --channels distance")
        brick, number, entry = self._find(cells)
        stored = self.distances.reshape(-1, 512)[np.maximum(brick, 0), number]
        beyond = np.where(entry == INTERIOR, -self.distance_band, self.distance_band)
        return np.where(brick >= 0, stored * self.distance_step, beyond)

    def layer(self, cells):
        """Number of the ring around the surface of cells (..., 3): 0 surface, above outside, below inside; beyond the last ring
        L it is L + 1, or minus that. Raises ValueError for a map without the channel."""
        if self.layers is None:
            raise ValueError(f"{self.path}: has no layers: voxshell convert --channels layers")
        brick, number, entry = self._find(cells)
        stored = self.layers.reshape(-1, 512)[np.maximum(brick, 0), number].astype(np.int64)
        beyond = self.c.layer_count + 1
        return np.where(brick >= 0, stored, np.where(entry == INTERIOR, -beyond, beyond))

    def states(self, low=None, high=None):
        """A box of cells, from low to high (both in it; the bounding box of what is not free): uint8 of shape high - low + 1."""
        low, high = (np.asarray(self.bbox[n] if given is None else given, dtype=np.int64) for n, given in ((0, low), (1, high)))
        grid = np.stack(np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(low, high)), indexing="ij"), axis=-1)
        return self.state(grid)

    def surface(self):
        """The surface cells: (surface_cells, 3) int64, in the file's order."""
        place = np.flatnonzero(self.root.reshape(-1) >= 4)
        chunk = np.stack(np.unravel_index(place, self.root.shape), axis=-1) * 64 + np.array(list(self.c.origin_cell))
        entry = np.flatnonzero(self.chunks.reshape(-1) >= 4)
        corner = chunk[entry >> 9] + 8 * np.stack([entry >> 6 & 7, entry >> 3 & 7, entry & 7], axis=-1)
        shifts = np.arange(0, 64, 2, dtype=np.uint64)
        found = []
        for n in range(0, len(self.bricks), _BLOCK):
            states = (self.bricks[n:n + _BLOCK, :, None] >> shifts & np.uint64(3)).reshape(-1, 512)
            brick, cell = np.nonzero(states == SURFACE)
            found.append(corner[n + brick] + np.stack([cell >> 6, cell >> 3 & 7, cell & 7], axis=-1))
        return np.concatenate(found)

    def cells_of(self, points):
        """The cells that points (..., 3) [m] are in: int64."""
        return np.floor(np.asarray(points) / self.voxel).astype(np.int64)
