#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Odd files, made from the goldens: VALID ones that break no rule although they look as if, and files in ORDER, which
break two, of which a reader names the first."""
import os
import struct

from make_invalid import (BARE, CHANNELS, CLEARANCE, MAP, MOVED, POINT, PRESSED, Draft, asset, both, byte, drop, effect, grid, insert,
                          move, plan, resize, shel, table, value)

FREE, SURFACE, INTERIOR, FIRST = 0, 1, 2, 4
ALL = {SURFACE: 0x5555555555555555, INTERIOR: 0xAAAAAAAAAAAAAAAA}


def brick(*cells):
    """16 words with these cells (i, j, k, state) in them, the others free."""
    words = [0] * 16
    for i, j, k, state in cells:
        cell = i * 64 + j * 8 + k
        words[cell // 32] |= state << (cell % 32 * 2)
    return words


def state_in(words, cell):
    return words[cell // 32] >> (cell % 32 * 2) & 3


class Cells:
    """A map from its entries: chunks are lists of 512, bricks of 16 words. Counts and box are those of the cells."""

    def __init__(self, dims, root, chunks=(), bricks=()):
        self.dims, self.root, self.chunks, self.bricks = dims, list(root), chunks, bricks

    def corner(self, n):
        _, dj, dk = self.dims
        return n // dk // dj, n // dk % dj, n % dk

    def pieces(self):
        """(corner, edge, state) of all that is not free."""
        for n, entry in enumerate(self.root):
            chunk = [64 * c for c in self.corner(n)]
            if entry < FIRST:
                yield chunk, 64, entry
                continue
            for slot, inner in enumerate(self.chunks[entry - FIRST]):
                at = [chunk[0] + slot // 64 * 8, chunk[1] + slot // 8 % 8 * 8, chunk[2] + slot % 8 * 8]
                if inner < FIRST:
                    yield at, 8, inner
                    continue
                for cell in range(512):
                    yield [at[0] + cell // 64, at[1] + cell // 8 % 8, at[2] + cell % 8], 1, state_in(self.bricks[inner - FIRST], cell)

    def edit(self, d):
        used = [p for p in self.pieces() if p[2] != FREE]
        for axis in range(3):
            grid("dims", self.dims[axis], axis)(d)
            grid("origin", 0, axis)(d)
            grid("min", min(at[axis] for at, _, _ in used), axis)(d)
            grid("max", max(at[axis] + edge - 1 for at, edge, _ in used), axis)(d)
        grid("surface", sum(edge**3 for _, edge, state in used if state == SURFACE))(d)
        grid("interior", sum(edge**3 for _, edge, state in used if state == INTERIOR))(d)
        d.bytes_of("ROOT")[:] = struct.pack(f"<{len(self.root)}I", *self.root)
        d.bytes_of("CHNK")[:] = b"".join(struct.pack("<512I", *c) for c in self.chunks)
        d.bytes_of("BRIK")[:] = b"".join(struct.pack("<16Q", *b) for b in self.bricks)

    def around(self, n):
        at, own = self.corner(n), self.root[n]
        for step in range(27):
            near = [at[0] + step // 9 - 1, at[1] + step // 3 % 3 - 1, at[2] + step % 3 - 1]
            inside = all(0 <= c < d for c, d in zip(near, self.dims))
            if own >= FIRST or (self.root[(near[0] * self.dims[1] + near[1]) * self.dims[2] + near[2]] if inside else FREE) != own:
                return FIRST
        return own

    def block(self, n, at):
        """1, -1 or 0: what the eight cells in the middle of a block of chunk n are; at: its first cell."""
        entry = self.root[n]
        if entry >= FIRST:
            entry = self.chunks[entry - FIRST][at[0] // 8 * 64 + at[1] // 8 * 8 + at[2] // 8]
        states = {entry}
        if entry >= FIRST:
            states = {state_in(self.bricks[entry - FIRST], (at[0] % 8 + 1 + e // 4) * 64 + (at[1] % 8 + 1 + e // 2 % 2) * 8 + at[2] % 8 + 1 + e % 2)
                      for e in range(8)}
        return 1 if states == {FREE} else -1 if states == {INTERIOR} else 0

    def clear(self, d):
        """With the smallest clearance that is one, and planes that say nothing."""
        self.edit(d)
        index, values, chunks = [], bytearray(), []
        for n in range(len(self.root)):
            around = self.around(n)
            index.append(around if around < FIRST else FIRST + len(values) // 4096)
            chunks.append({FREE: 96, INTERIOR: -96}.get(around, 0))
            if around >= FIRST:
                values += struct.pack("<4096b", *(self.block(n, (b // 256 * 4, b // 16 % 16 * 4, b % 16 * 4)) for b in range(4096)))
        d.bytes_of("CLRX")[:] = struct.pack(f"<{len(index)}I", *index)
        d.bytes_of("CLRV")[:] = values
        d.bytes_of("CLRC")[:] = struct.pack(f"<{len(chunks)}i", *chunks)
        d.bytes_of("CLRP")[:] = b"\0\0\0\xff" * 512 * len(self.chunks)


def one_chunk(*words):
    """A chunk whose first bricks are these, the others free."""
    return Cells((1, 1, 1), [FIRST], [[FIRST + n for n in range(len(words))] + [FREE] * (512 - len(words))], words)


CORNER = one_chunk(brick((0, 0, 0, SURFACE)))  # of the box, so that no chunk is free throughout
# A free chunk in the corner of a box of 3 x 3, with all free around it; the chunk that follows it in ROOT is not.
FAR_CORNER = Cells((1, 3, 3), [INTERIOR, FREE, FREE, FIRST, FREE, FREE, FREE, FREE, INTERIOR], CORNER.chunks, CORNER.bricks)
# Solid but for one chunk: the middle of the first 3 x 3 x 3 is interior all around.
SOLID = Cells((4, 3, 3), [INTERIOR] * 27 + [FIRST] + [FREE] * 8, CORNER.chunks, CORNER.bricks)
# A block whose middle holds a surface cell, one that is solid there, one that is both, one where only the last cell differs.
MIDDLES = one_chunk(brick((1, 1, 1, SURFACE), *((i, j, k, INTERIOR) for i in (5, 6) for j in (5, 6) for k in (5, 6)),
                          *((i, j, k, INTERIOR) for i in (1, 2) for j in (5, 6) for k in (1, 2) if (i, j, k) != (2, 6, 2))))
INSIDE = both(value("BRIK", "Q", 0, INTERIOR), grid("interior", 1), grid("min", 0), value("LAYR", "b", 0, -1))
NEGATIVE = both(INSIDE, grid("flags", 0), value("DIST", "h", 0, -5))

VALID = [
    (MAP, insert(4, "X0Z9")),
    (MAP, insert(4, "A9Z0")),
    (MAP, Cells((2, 2, 1), [FREE, FIRST, INTERIOR, FREE], CORNER.chunks, CORNER.bricks).edit),
    (MAP, one_chunk([ALL[SURFACE]] * 16).edit),
    (MAP, one_chunk(brick((7, 7, 7, SURFACE))).edit),
    (MAP, one_chunk(brick((0, 0, 0, SURFACE)), [ALL[INTERIOR]] + [ALL[SURFACE]] * 15).edit),
    (CHANNELS, both(drop("DIST"), grid("step", 0.0), grid("band", 0.0), grid("error", 0.0), grid("flags", 0))),
    (CHANNELS, both(drop("LAYR"), grid("layers", 0))),
    (CHANNELS, INSIDE),
    (CHANNELS, NEGATIVE),
    (CHANNELS, both(grid("flags", 0), value("DIST", "h", 448, -1))),
    (CHANNELS, both(grid("flags", 0), value("DIST", "h", 448, 1))),
    (CLEARANCE, FAR_CORNER.clear),
    (CLEARANCE, SOLID.clear),
    (CLEARANCE, MIDDLES.clear),
    (CLEARANCE, drop("CLRP")),
    (CLEARANCE, value("CLRP", "i", 0, -1 << 24)),
    (POINT, both(shel("center", -1.0), shel("radius", 9.0))),
    (BARE, both(plan("law", 3), plan("field", 3))),
    (BARE, both(plan("coupling", 4), plan("evaluations", 3), plan("spring", 100.0), plan("radius", 0.01))),
    (PRESSED, effect(0, "kind", b"k0-9")),
    (MOVED, both(lambda d: d.bytes_of("ASST").extend(d.bytes_of("ASST")[-384:]), asset(2, "role", 1), move(0, "time", 1.5), move(1, "asset", 2),
                 move(1, "time", 0.0))),
]

# More files that break one rule, made from those.
INVALID = [
    ("M401", CHANNELS, both(INSIDE, value("LAYR", "b", 0, 1))),
    ("M401", CHANNELS, both(INSIDE, value("LAYR", "b", 0, -5))),
    ("M402", CHANNELS, both(NEGATIVE, value("DIST", "h", 0, 5))),
    ("M402", CHANNELS, value("DIST", "h", 448, -1)),
    ("M501", CLEARANCE, both(FAR_CORNER.clear, value("CLRX", "I", 2, 2))),
    ("M501", CLEARANCE, both(SOLID.clear, value("CLRX", "I", 13, 0))),
    ("M502", CLEARANCE, both(MIDDLES.clear, value("CLRV", "b", 0, 1))),
    ("M502", CLEARANCE, both(MIDDLES.clear, value("CLRV", "b", 1 + 16 + 256, 0))),
    ("M502", CLEARANCE, both(MIDDLES.clear, value("CLRV", "b", 1 + 16 + 256, 1))),
    ("M502", CLEARANCE, both(MIDDLES.clear, value("CLRV", "b", 16, -1))),
    ("M502", CLEARANCE, both(MIDDLES.clear, value("CLRV", "b", 16, 1))),
    ("M503", CLEARANCE, both(SOLID.clear, value("CLRC", "i", 13, 96))),
    ("M503", CLEARANCE, both(SOLID.clear, value("CLRC", "i", 13, -95))),
    ("M504", CLEARANCE, value("CLRP", "I", 1, 50)),
]

ORDER = [
    ("C301", MAP, both(byte(128 + 40 * 5 + 1, 1), table(0, crc=0))),
    ("S207", POINT, both(shel("center", float("nan")), shel("gap", -1.0))),
]


def built(golden, edit):
    draft = Draft(golden)
    edit(draft)
    return draft.build()


def valid():
    """(name, bytes) of each valid one."""
    for n, (golden, edit) in enumerate(VALID):
        yield f"valid-{n + 1}{os.path.splitext(golden)[1]}", built(golden, edit)


def invalid():
    """(name, rule, bytes): rule is the first that is broken."""
    for n, (rule, golden, edit) in enumerate(INVALID + ORDER):
        yield f"{rule}-odd-{n + 1}{os.path.splitext(golden)[1]}", rule, built(golden, edit)
