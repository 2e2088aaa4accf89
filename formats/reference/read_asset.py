#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Reads .voxmap, .pointshell and .plan files. Written from container.md, voxmap.md, pointshell.md and plan.md alone;
shares no code with the runtime. Python 3.9 or newer, standard library only.

    read_asset.py FILE           JSON summary
    read_asset.py --check FILE   "OK", or the first broken rule and exit status 3

As a module: open_asset(path) gives a Voxmap (state(), cells()), a Pointshell (points()) or a Plan (assets, effects, hand).
Exit status: 0 ok, 1 usage, 2 the file cannot be read, 3 it breaks a rule.
"""
import array
import hashlib
import itertools
import json
import math
import struct
import sys
import zlib

HEADER = struct.Struct("<8sHHIQIIIIQ32s32sI2II")
ENTRY = struct.Struct("<IIQQQII")
GRID = struct.Struct("<d3q3IIQQ3q3qdddII48s")
INFO = struct.Struct("<dIIIIddd3ddQ24s")
CLUSTER = struct.Struct("<4fII2I")
PLAN = struct.Struct("<dIIIIdddIIII6d6d7d7d48s16s48s")
PLANNED = struct.Struct("<II7d32s256s32s")
EFFECT = struct.Struct("<32sII24d")
KEYFRAME = struct.Struct("<d7dII7d")
MOTION = struct.Struct("<d7dII")

MAGIC = {b"\x89VXM\r\n\x1a\n": "voxmap", b"\x89VXP\r\n\x1a\n": "pointshell",
         b"\x89VXL\r\n\x1a\n": "plan"}
MAJOR = {"voxmap": 1, "pointshell": 1, "plan": 1}
NO_AREA = 1
FEATURES = {"pointshell": NO_AREA}  # bits of required_features that are known
FREE, SURFACE, INTERIOR = 0, 1, 2
FIRST = 4  # entries from here on are numbers of chunks or bricks


class Broken(Exception):
    """The first rule that a file breaks."""

    def __init__(self, rule, section, offset, text):
        super().__init__(f"rule {rule} section {section} offset {offset}: {text}")
        self.rule, self.section, self.offset, self.text = rule, section, offset, text


def round64(n):
    return (n + 63) // 64 * 64


def ones(bits):
    return bin(bits).count("1")


def finite_not_negative(value):
    return 0 <= value < math.inf


def amount(value):
    """Finite, not negative and not -0."""
    return finite_not_negative(value) and math.copysign(1.0, value) > 0


class Section:
    def __init__(self, name, stride, count, offset, size, entry_offset):
        self.name, self.stride, self.count, self.offset, self.size = name, stride, count, offset, size
        self.entry_offset = entry_offset  # of its line in the table


class Asset:
    """Header and sections of a file that breaks no rule of container.md (C303 comes last: check_content_hash)."""

    def __init__(self, data):
        self.data = memoryview(data)
        self.check_header()
        self.sections = self.check_table()
        self.check_padding_and_sums()
        self.by_name = {s.name: s for s in self.sections}

    def check_header(self):
        def need(condition, rule, offset, text):
            if not condition:
                raise Broken(rule, "HEAD", offset, text)

        data = self.data
        need(len(data) >= 128, "C101", 0, f"{len(data)} bytes are no header")
        (magic, self.major, self.minor, header_size, file_size, required, self.optional, self.section_count, entry_size,
         table_offset, self.content_hash, self.source_hash, self.table_crc, reserved0, reserved1,
         header_crc) = HEADER.unpack_from(data)
        need(magic in MAGIC, "C102", 0, "no voxshell magic")
        self.kind = MAGIC[magic]
        need(self.major == MAJOR[self.kind], "C103", 8,
             f"{self.kind} version {self.major}.{self.minor}, this reader knows {MAJOR[self.kind]}.0")
        need(header_crc == zlib.crc32(data[:124]), "C104", 124, "header checksum differs")
        need(required & ~FEATURES.get(self.kind, 0) == 0, "C105", 24, f"unknown required features {required:#x}")
        self.features = required
        need(file_size == len(data), "C106", 16, f"file_size {file_size}, but the file has {len(data)} bytes")
        need(1 <= self.section_count <= 64 and 128 + 40 * self.section_count <= file_size, "C107", 32,
             f"section_count {self.section_count}")
        need(header_size == 128, "C108", 12, f"header_size {header_size}")
        need(entry_size == 40, "C108", 36, f"section_entry_size {entry_size}")
        need(table_offset == 128, "C108", 40, f"section_table_offset {table_offset}")
        need(reserved0 == 0 and reserved1 == 0, "C109", 116, "reserved is not 0")
        need(self.table_crc == zlib.crc32(data[128:128 + 40 * self.section_count]), "C110", 112, "table checksum differs")

    def check_table(self):
        def need(condition, rule, offset, text):
            if not condition:
                raise Broken(rule, "TABL", offset, text)

        sections, names, self.crcs = [], set(), []
        end = 128 + 40 * self.section_count
        for n in range(self.section_count):
            at = 128 + 40 * n
            ident, stride, count, offset, size, crc, reserved = ENTRY.unpack_from(self.data, at)
            name = struct.pack("<I", ident).decode("latin-1")
            need(all("A" <= c <= "Z" or "0" <= c <= "9" for c in name), "C201", at, "id is not four of A-Z 0-9")
            need(name not in ("HEAD", "TABL") and name not in names, "C201", at, f"id {name} is reserved or there twice")
            need(stride >= 1, "C202", at + 4, "stride 0")
            need(count >= 1, "C202", at + 8, "count 0")
            need(size == stride * count, "C202", at + 24, f"size {size} is not stride * count")
            need(offset == round64(end), "C203", at + 16, f"offset {offset} instead of {round64(end)}")
            need(offset + size <= len(self.data), "C203", at + 16, "section leaves the file")
            need(reserved == 0, "C204", at + 36, "reserved is not 0")
            end = offset + size
            names.add(name)
            self.crcs.append(crc)
            sections.append(Section(name, stride, count, offset, size, at))
        if round64(end) != len(self.data):
            raise Broken("C205", "HEAD", 16, "file_size is not the end of the last section")
        last = sections[-1]
        need(last.name == "META", "C206", last.entry_offset, "the last section is not META")
        need(last.stride == 1, "C206", last.entry_offset, f"stride {last.stride} of META")
        return sections

    def check_padding_and_sums(self):
        starts = [s.offset for s in self.sections] + [len(self.data)]
        ends = [128 + 40 * self.section_count] + [s.offset + s.size for s in self.sections]
        owners = ["TABL"] + [s.name for s in self.sections]
        for owner, begin, stop in zip(owners, ends, starts):
            for offset in range(begin, stop):
                if self.data[offset]:
                    raise Broken("C301", owner, offset, "padding is not 0")
        for section, crc in zip(self.sections, self.crcs):
            if crc != zlib.crc32(self.bytes_of(section)):
                raise Broken("C302", section.name, section.offset, "checksum differs")

    def check_content_hash(self):
        content = hashlib.sha256()
        for section in self.sections:
            if section.name != "META":
                content.update(section.name.encode() + struct.pack("<IQ", section.stride, section.count))
                content.update(self.bytes_of(section))
        if content.digest() != self.content_hash:
            raise Broken("C303", "HEAD", 48, "content hash differs")

    def bytes_of(self, section):
        return self.data[section.offset:section.offset + section.size]

    def array(self, name, code):
        """A section as an array of numbers."""
        values = array.array(code)
        values.frombytes(self.bytes_of(self.by_name[name]))
        if sys.byteorder == "big":
            values.byteswap()
        return values

    def check_layout(self, rule, strides, optional=()):
        """The known sections come first and in order (rule), with their strides and one first element (rule + 1)."""
        expected = [n for n in strides if n not in optional or n in self.by_name]
        for n, name in enumerate(expected):
            there = self.sections[min(n, len(self.sections) - 1)]
            if there.name != name:
                raise Broken(rule + "01", "TABL", there.entry_offset, f"{there.name} where {name} belongs")
        for n, name in enumerate(expected):
            section = self.sections[n]
            if section.stride != strides[name]:
                raise Broken(rule + "02", "TABL", section.entry_offset, f"stride {section.stride} of {name}")
            if n == 0 and section.count != 1:
                raise Broken(rule + "02", "TABL", section.entry_offset, f"{section.count} elements in {name}")

    def summary(self):
        return {"kind": self.kind, "format": f"{self.major}.{self.minor}", "bytes": len(self.data),
                "source_sha256": self.source_hash.hex(), "content_hash": self.content_hash.hex()}


class Voxmap(Asset):
    STRIDES = {"GRID": 192, "ROOT": 4, "CHNK": 2048, "BRIK": 128, "LAYR": 512, "DIST": 1024, "CLRX": 4,
               "CLRV": 4096, "CLRC": 4, "CLRP": 2048}
    CLEARANCE = ("CLRX", "CLRV", "CLRC")
    LOW_BITS = int("01" * 512, 2)  # the lower bit of all 512 states

    def __init__(self, data):
        super().__init__(data)
        self.check_layout("M1", self.STRIDES, optional=("LAYR", "DIST", *self.CLEARANCE, "CLRP"))
        self.channels = [n for n in ("LAYR", "DIST") if n in self.by_name]
        for name in self.channels:
            if self.by_name[name].count != self.by_name["BRIK"].count:
                raise Broken("M103", "TABL", self.by_name[name].entry_offset, f"{name} is not as long as BRIK")
        trio = [self.by_name[n] for n in self.CLEARANCE if n in self.by_name]
        if trio and (len(trio) != 3 or trio[0].count != self.by_name["ROOT"].count or trio[2].count != trio[0].count):
            raise Broken("M104", "TABL", trio[0].entry_offset, "CLRX, CLRV and CLRC do not fit each other or ROOT")
        planes = self.by_name.get("CLRP")
        if planes and not (trio and planes.count == self.by_name["CHNK"].count):
            raise Broken("M105", "TABL", planes.entry_offset, "CLRP does not fit CHNK, or is there without CLRX")
        self.check_grid()
        self.root = self.array("ROOT", "I")
        self.chunks = self.array("CHNK", "I")
        self.check_entries()
        self.check_bricks()
        self.check_counts()
        self.check_channels()
        self.check_clearance()
        self.check_planes()
        self.check_content_hash()

    def check_grid(self):
        start = self.by_name["GRID"].offset

        def need(condition, rule, field, text):
            if not condition:
                raise Broken(rule, "GRID", start + field, text)

        values = GRID.unpack_from(self.data, start)
        self.voxel, self.origin, self.dims, self.layer_count = values[0], values[1:4], values[4:7], values[7]
        self.surface_cells, self.interior_cells = values[8:10]
        self.bbox_min, self.bbox_max = values[10:13], values[13:16]
        self.distance_step, self.distance_band, self.distance_error, self.flags, reserved, pad = values[16:]

        need(1e-12 <= self.voxel <= 1e3, "M201", 0, f"voxel {self.voxel} m")
        for a in range(3):
            need(self.origin[a] % 64 == 0 and -2**44 <= self.origin[a] < 2**44, "M202", 8 + 8 * a,
                 f"origin_cell {self.origin[a]}")
        for a in range(3):
            need(self.dims[a] >= 1, "M203", 32 + 4 * a, "root_dims 0")
        for a in range(3):
            need(self.dims[a] <= 16384 and self.origin[a] + 64 * self.dims[a] <= 2**44, "M204", 32 + 4 * a,
                 f"root_dims {self.dims[a]}")
        chunks = self.dims[0] * self.dims[1] * self.dims[2]
        need(chunks <= 2**24, "M205", 32, f"{chunks} chunks in the box")
        for name, rule, good in (("BRIK", "M206", self.by_name["BRIK"].count <= 2**28),
                                 ("ROOT", "M207", self.by_name["ROOT"].count == chunks)):
            if not good:
                entry = self.by_name[name]
                raise Broken(rule, "TABL", entry.entry_offset, f"{entry.count} elements in {name}")
        need(self.flags & ~3 == 0, "M208", 136, f"flags {self.flags:#x}")
        for n, byte in enumerate(struct.pack("<I", reserved) + pad):
            need(byte == 0, "M208", 140 + n, "a reserved byte is not 0")
        need(1 <= self.layer_count <= 126 if "LAYR" in self.channels else self.layer_count == 0, "M209", 44,
             f"layer_count {self.layer_count}")
        if "DIST" in self.channels:
            step, band = self.distance_step, self.distance_band
            need(1e-30 <= step < math.inf, "M210", 112, f"distance_step {step}")
            need(step <= band < math.inf and band <= 32767.0 * step, "M210", 120, f"distance_band {band}")
            need(finite_not_negative(self.distance_error), "M210", 128, f"distance_error {self.distance_error}")
        else:
            for field in (112, 120, 128):
                need(not any(self.data[start + field:start + field + 8]), "M210", field, "distances without DIST")
            need(self.flags & 2 == 0, "M210", 136, "UNSIGNED without DIST")
        need(self.surface_cells >= 1, "M211", 48, "no surface cell")

    def check_entries(self):
        def numbered(entries, section, rule, below, after_512):
            """Entries are uniform or count upwards; `after_512` sees each chunk."""
            start = self.by_name[section].offset
            following = FIRST
            for n, entry in enumerate(entries):
                if entry == following:
                    following += 1
                elif entry not in (FREE, INTERIOR):
                    raise Broken(rule, section, start + 4 * n, f"entry {entry} instead of 0, 2 or {following}")
                if after_512 and n % 512 == 511:
                    after_512(n - 511)
            if following - FIRST != self.by_name[below].count:
                raise Broken(rule, section, start, f"{following - FIRST} numbers for {self.by_name[below].count} of {below}")

        def not_uniform(first):
            chunk = self.chunks[first:first + 512]
            if chunk[0] in (FREE, INTERIOR) and chunk.count(chunk[0]) == 512:
                raise Broken("M304", "CHNK", self.by_name["CHNK"].offset + 4 * first, "the chunk is uniform")

        numbered(self.root, "ROOT", "M301", "CHNK", None)
        self.check_box()
        numbered(self.chunks, "CHNK", "M303", "BRIK", not_uniform)

    def check_box(self):
        d0, d1, d2 = self.dims
        used = [set(), set(), set()]
        for n, entry in enumerate(self.root):
            if entry != FREE:
                for axis, index in enumerate((n // (d1 * d2), n // d2 % d1, n % d2)):
                    used[axis].add(index)
        for axis in range(3):
            if not {0, self.dims[axis] - 1} <= used[axis]:
                raise Broken("M302", "ROOT", self.by_name["ROOT"].offset, f"a side of the box on axis {axis} is free")

    def brick(self, number):
        """All states of a brick as one number: bits 2c and 2c + 1 are the state of cell c."""
        start = self.by_name["BRIK"].offset + 128 * number
        return int.from_bytes(self.data[start:start + 128], "little")

    def check_bricks(self):
        start = self.by_name["BRIK"].offset
        low = self.LOW_BITS
        for n in range(self.by_name["BRIK"].count):
            bits = self.brick(n)
            three = bits & bits >> 1 & low
            if three:
                lowest = (three & -three).bit_length() - 1
                raise Broken("M305", "BRIK", start + 128 * n + lowest // 64 * 8, "a cell of state 3")
            if not self.channels and bits in (0, low << 1):
                raise Broken("M306", "BRIK", start + 128 * n, "the brick is uniform")

    def entries(self):
        """(i, j, k, edge, entry) of all uniform chunks, uniform bricks (entry 0 or 2) and bricks (entry >= 4):
        absolute cell of the corner, edge in cells. In the order of ROOT and CHNK."""
        d1, d2 = self.dims[1:]
        for n, entry in enumerate(self.root):
            corner = (self.origin[0] + 64 * (n // (d1 * d2)), self.origin[1] + 64 * (n // d2 % d1),
                      self.origin[2] + 64 * (n % d2))
            if entry < FIRST:
                yield corner + (64, entry)
                continue
            for slot in range(512):
                yield (corner[0] + 8 * (slot >> 6), corner[1] + 8 * (slot >> 3 & 7), corner[2] + 8 * (slot & 7), 8,
                       self.chunks[(entry - FIRST) * 512 + slot])

    def check_counts(self):
        surface = interior = 0
        least, most = [math.inf] * 3, [-math.inf] * 3

        def grow(axis, first, last):
            least[axis] = min(least[axis], first)
            most[axis] = max(most[axis], last)

        for *corner, edge, entry in self.entries():
            if entry == INTERIOR:
                interior += edge**3
            if entry == FREE:
                continue
            if entry >= FIRST:
                bits = self.brick(entry - FIRST)
                surface += ones(bits & self.LOW_BITS)
                interior += ones(bits >> 1 & self.LOW_BITS)
            if all(least[a] <= corner[a] and corner[a] + edge - 1 <= most[a] for a in range(3)):
                continue
            if entry == INTERIOR:
                for a in range(3):
                    grow(a, corner[a], corner[a] + edge - 1)
                continue
            for c in range(512):
                if bits >> 2 * c & 3:
                    for a, inner in enumerate((c >> 6, c >> 3 & 7, c & 7)):
                        grow(a, corner[a] + inner, corner[a] + inner)

        start = self.by_name["GRID"].offset
        for field, stated, counted in ((48, self.surface_cells, surface), (56, self.interior_cells, interior)):
            if stated != counted:
                raise Broken("M307", "GRID", start + field, f"{stated} cells stated, {counted} counted")
        for field, stated, found in ((64, self.bbox_min, least), (88, self.bbox_max, most)):
            for a in range(3):
                if stated[a] != found[a]:
                    raise Broken("M308", "GRID", start + field + 8 * a, f"bound {stated[a]} stated, {found[a]} found")

    def check_channels(self):
        def each_value(name, code):
            values, start = self.array(name, code), self.by_name[name].offset
            for n in range(self.by_name["BRIK"].count):
                bits = self.brick(n)
                for c in range(512):
                    value = values[512 * n + c]
                    yield value, bits >> 2 * c & 3, start + (512 * n + c) * values.itemsize

        if "LAYR" in self.channels:
            beyond = self.layer_count + 1
            allowed = {SURFACE: (0, 0), FREE: (1, beyond), INTERIOR: (-beyond, -1)}
            for value, state, offset in each_value("LAYR", "b"):
                least, most = allowed[state]
                if not least <= value <= most:
                    raise Broken("M401", "LAYR", offset, f"layer {value} in a cell of state {state}")
        if "DIST" in self.channels:
            for value, state, offset in each_value("DIST", "h"):
                wrong_sign = value < 0 if self.flags & 2 or state == FREE else value > 0 and state == INTERIOR
                if wrong_sign or abs(value) * self.distance_step > self.distance_band:
                    raise Broken("M402", "DIST", offset, f"distance {value} in a cell of state {state}")

    def check_clearance(self):
        if "CLRX" not in self.by_name:
            return
        index, values, chunks = self.array("CLRX", "I"), self.array("CLRV", "b"), self.array("CLRC", "i")
        index_at, values_at, chunks_at = (self.by_name[n].offset for n in self.CLEARANCE)
        following = FIRST
        for n, entry in enumerate(index):
            around = self.root_around(n)
            expected = around.pop() if len(around) == 1 and around < {FREE, INTERIOR} else following
            if entry != expected:
                raise Broken("M501", "CLRX", index_at + 4 * n, f"entry {entry} of chunk {n} is not {expected}")
            following += entry == following
        if following - FIRST != self.by_name["CLRV"].count:
            raise Broken("M501", "CLRX", index_at, f"{following - FIRST} elements of CLRV numbered")
        for n, entry in enumerate(index):
            if entry < FIRST:
                continue
            first = 4096 * (entry - FIRST)
            for b in range(4096):
                value, state = values[first + b], self.state_around_center(n, b)
                least, most = (1, 127) if state == FREE else (-127, -1) if state == INTERIOR else (0, 0)
                if not least <= value <= most:
                    raise Broken("M502", "CLRV", values_at + first + b, f"clearance {value} where the state is {state}")
        for n, (entry, value) in enumerate(zip(index, chunks)):
            least, most = (96, 4096) if entry == FREE else (-4096, -96) if entry == INTERIOR else (0, 0)
            if not least <= value <= most:
                raise Broken("M503", "CLRC", chunks_at + 4 * n, f"clearance {value} of chunk {n}, whose entry is {entry}")

    def check_planes(self):
        if "CLRP" not in self.by_name:
            return
        values, start = self.array("CLRP", "b"), self.by_name["CLRP"].offset
        for n, entry in enumerate(self.chunks):
            *normal, offset = values[4 * n:4 * n + 4]
            longest = max(map(abs, normal))
            says_nothing = longest == 0 and offset == -1
            if not (says_nothing or entry != INTERIOR and (longest == 127 or longest == offset == 0)):
                raise Broken("M504", "CLRP", start + 4 * n, f"plane {normal}, {offset} of a brick whose entry is {entry}")

    def root_around(self, chunk):
        """The different ROOT entries of a chunk and the 26 around it."""
        at = (chunk // self.dims[2] // self.dims[1], chunk // self.dims[2] % self.dims[1], chunk % self.dims[2])
        found = set()
        for step in itertools.product((-1, 0, 1), repeat=3):
            i, j, k = (a + s for a, s in zip(at, step))
            inside = all(0 <= a < d for a, d in zip((i, j, k), self.dims))
            found.add(self.root[(i * self.dims[1] + j) * self.dims[2] + k] if inside else FREE)
        return found

    def state_around_center(self, n, block):
        """State of the eight cells around the centre of a block of chunk n, SURFACE where they differ."""
        entry = self.root[n]
        i, j, k = block >> 8, block >> 4 & 15, block & 15
        if entry >= FIRST:
            entry = self.chunks[(entry - FIRST) * 512 + (i >> 1 << 6 | j >> 1 << 3 | k >> 1)]
        if entry < FIRST:
            return entry
        bits, corner = self.brick(entry - FIRST), (i & 1) << 8 | (j & 1) << 5 | (k & 1) << 2
        around = {bits >> 2 * (corner + c) & 3 for c in (73, 74, 81, 82, 137, 138, 145, 146)}
        return around.pop() if len(around) == 1 else SURFACE

    def state(self, i, j, k):
        """State of an absolute cell."""
        c = [x - o for x, o in zip((i, j, k), self.origin)]
        if not all(0 <= c[a] < 64 * self.dims[a] for a in range(3)):
            return FREE
        entry = self.root[((c[0] >> 6) * self.dims[1] + (c[1] >> 6)) * self.dims[2] + (c[2] >> 6)]
        if entry >= FIRST:
            entry = self.chunks[(entry - FIRST) * 512 + ((c[0] >> 3 & 7) << 6 | (c[1] >> 3 & 7) << 3 | (c[2] >> 3 & 7))]
        if entry < FIRST:
            return entry
        return self.brick(entry - FIRST) >> 2 * ((c[0] & 7) << 6 | (c[1] & 7) << 3 | (c[2] & 7)) & 3

    def cells(self):
        """(i, j, k, state) of all cells that are not free, chunk by chunk and brick by brick."""
        for i, j, k, edge, entry in self.entries():
            if entry == FREE:
                continue
            shift = edge.bit_length() - 1
            bits = self.brick(entry - FIRST) if entry >= FIRST else 0
            for c in range(edge**3):
                state = bits >> 2 * c & 3 if entry >= FIRST else entry
                if state:
                    yield i + (c >> 2 * shift), j + (c >> shift & edge - 1), k + (c & edge - 1), state

    def summary(self):
        names = {"LAYR": "layers", "DIST": "distance"}
        return {**super().summary(), "voxel_m": self.voxel,
                "bbox_cells": {"min": list(self.bbox_min), "max": list(self.bbox_max)},
                "surface_cells": self.surface_cells, "interior_cells": self.interior_cells,
                "channels": [names[n] for n in self.channels]}


class Pointshell(Asset):
    COLUMNS = ("POSX", "POSY", "POSZ", "NRMX", "NRMY", "NRMZ", "AREA")
    STRIDES = {"SHEL": 112, **{n: 4 for n in COLUMNS}, "CLUS": 32}

    def __init__(self, data):
        super().__init__(data)
        self.has_areas = not self.features & NO_AREA
        self.here = self.COLUMNS if self.has_areas else self.COLUMNS[:-1]
        self.check_layout("S1", {n: s for n, s in self.STRIDES.items() if n in (*self.here, "SHEL", "CLUS")})
        if not self.has_areas and "AREA" in self.by_name:
            raise Broken("S103", "TABL", self.by_name["AREA"].entry_offset, "areas in a shell that has none")
        self.check_info()
        self.columns = [self.array(n, "f") for n in self.here]
        self.check_points()
        self.check_padding()
        self.check_clusters()
        self.check_content_hash()

    def check_info(self):
        start = self.by_name["SHEL"].offset

        def need(condition, rule, field, text):
            if not condition:
                raise Broken(rule, "SHEL", start + field, text)

        (self.voxel, self.kind_of_shell, self.point_count, self.padded_count, self.cluster_count, self.area, self.gap_max,
         self.surface_error, cx, cy, cz, self.radius, self.surface_cells, pad) = INFO.unpack_from(self.data, start)
        self.center = (cx, cy, cz)
        need(1e-12 <= self.voxel <= 1e3, "S201", 0, f"voxel {self.voxel} m")
        need(self.kind_of_shell in (1, 2), "S202", 8, f"kind {self.kind_of_shell}")
        need(1 <= self.point_count <= 2**28, "S203", 12, f"point_count {self.point_count}")
        need(self.padded_count == (self.point_count + 15) // 16 * 16, "S204", 16, f"padded_count {self.padded_count}")
        need(self.cluster_count == (self.point_count + 63) // 64, "S205", 20, f"cluster_count {self.cluster_count}")
        for name in self.here + ("CLUS",):
            entry = self.by_name[name]
            if entry.count != (self.cluster_count if name == "CLUS" else self.padded_count):
                raise Broken("S206", "TABL", entry.entry_offset, f"{entry.count} elements in {name}")
        for field, value in ((24, self.area), (32, self.gap_max), (40, self.surface_error)):
            need(finite_not_negative(value), "S207", field, f"{value} is no length or area")
        for a in range(3):
            need(abs(self.center[a]) <= 1e15, "S207", 48 + 8 * a, f"center {self.center[a]}")
        need(finite_not_negative(self.radius), "S207", 72, f"radius {self.radius}")
        for n, byte in enumerate(pad):
            need(byte == 0, "S208", 88 + n, "pad is not 0")
        need(1 <= self.surface_cells <= self.point_count, "S209", 80, f"surface_cells {self.surface_cells}")

    def at(self, column, point):
        return self.by_name[self.COLUMNS[column]].offset + 4 * point

    def raw(self, column, point):
        return self.data[self.at(column, point):self.at(column, point) + 4]

    def check_points(self):
        x, y, z, nx, ny, nz = self.columns[:6]
        for n in range(self.point_count):
            for a, value in enumerate((x[n], y[n], z[n])):
                if not abs(value) <= 1e15:
                    raise Broken("S301", self.COLUMNS[a], self.at(a, n), f"coordinate {value} of point {n}")
        for n in range(self.point_count):
            if not abs((nx[n] * nx[n] + ny[n] * ny[n]) + nz[n] * nz[n] - 1.0) <= 1e-6:
                raise Broken("S302", "NRMX", self.at(3, n), f"the normal of point {n} has not length 1")
        if not self.has_areas:
            return
        area = self.columns[6]
        for n in range(self.point_count):
            if not (finite_not_negative(area[n]) and math.copysign(1.0, area[n]) > 0):
                raise Broken("S303", "AREA", self.at(6, n), f"area {area[n]} of point {n}")
        total = 0.0
        for n in range(self.point_count):
            total += area[n]  # not sum(): newer Pythons compensate there
        if not abs(total - self.area) <= 1e-6 * self.area:
            raise Broken("S304", "SHEL", self.by_name["SHEL"].offset + 24, f"area {self.area}, the points have {total}")

    def check_padding(self):
        for column in range(len(self.here)):
            last = self.raw(column, self.point_count - 1) if column < 6 else bytes(4)
            for n in range(self.point_count, self.padded_count):
                if self.raw(column, n) != last:
                    raise Broken("S305", self.COLUMNS[column], self.at(column, n), "the padding does not repeat the last point")

    def clusters(self):
        """(center, radius, first, count) of each cluster, after its rules."""
        start = self.by_name["CLUS"].offset
        for n in range(self.cluster_count):
            at = start + 32 * n
            cx, cy, cz, radius, first, count, reserved0, reserved1 = CLUSTER.unpack_from(self.data, at)

            def need(condition, rule, field, text):
                if not condition:
                    raise Broken(rule, "CLUS", at + field, text)

            need(first == 64 * n, "S401", 16, f"first {first} of cluster {n}")
            need(count == min(64, self.point_count - 64 * n), "S401", 20, f"count {count} of cluster {n}")
            for a, value in enumerate((cx, cy, cz)):
                need(abs(value) <= 1e15, "S402", 4 * a, f"center {value} of cluster {n}")
            need(0 <= radius <= 1e16, "S402", 12, f"radius {radius} of cluster {n}")
            need(reserved0 == 0 and reserved1 == 0, "S403", 24, "reserved is not 0")
            yield (cx, cy, cz), radius, first, count

    def check_clusters(self):
        def inside(rule, center, radius, points, what):
            x, y, z = self.columns[:3]
            for n in points:
                dx, dy, dz = x[n] - center[0], y[n] - center[1], z[n] - center[2]
                if not (dx * dx + dy * dy) + dz * dz <= radius * radius:
                    raise Broken(rule, "POSX", self.at(0, n), f"point {n} lies outside the sphere of {what}")

        for n, (center, radius, first, count) in enumerate(self.clusters()):
            inside("S404", center, radius, range(first, first + count), f"cluster {n}")
        inside("S405", self.center, self.radius, range(self.point_count), "the shell")

    def points(self):
        """(x, y, z, nx, ny, nz, area) of all points, without the padding; no area in a shell that has none."""
        return zip(*(column[:self.point_count] for column in self.columns))

    def summary(self):
        return {**super().summary(), "voxel_m": self.voxel, "kind_of_shell": {1: "exact", 2: "naive"}[self.kind_of_shell],
                "points": self.point_count, "area_m2": self.area, "areas": self.has_areas, "gap_max_m": self.gap_max,
                "surface_error_max_m": self.surface_error, "clusters": self.cluster_count}


class Plan(Asset):
    STRIDES = {"PLAN": 384, "ASST": 384, "EFCT": 232, "HAND": 128, "MOVE": 72}
    LAWS = {1: "original", 2: "average", 3: "gradient", 4: "patch"}
    FIELDS = {1: "surface", 2: "layers", 3: "distance"}
    WEIGHTINGS = {1: "count", 2: "count-capped", 3: "area"}
    COUPLINGS = {1: "none", 2: "pt2", 3: "spring-damper", 4: "quasi-static"}
    NUMBERS = ("omega0", "damping", "gain", "stiffness", "radius", "mass")
    HAS = {"none": (), "pt2": ("omega0", "damping", "gain"), "spring-damper": ("damping", "stiffness", "radius", "mass"),
           "quasi-static": ("stiffness", "radius")}

    def __init__(self, data):
        super().__init__(data)
        self.check_layout("P1", self.STRIDES, optional=("EFCT", "HAND", "MOVE"))
        self.check_info()
        self.check_assets()
        self.check_effects()
        self.check_hand()
        self.check_motion()
        self.check_content_hash()

    def elements(self, name, layout):
        """(offset in the file, fields) of each element of a section; nothing if it is not there."""
        if name in self.by_name:
            section = self.by_name[name]
            for n in range(section.count):
                at = section.offset + section.stride * n
                yield at, layout.unpack_from(self.data, at)

    def check_pose(self, rule, name, at, pose):
        """Of position and orientation (w x y z) that stand one after the other."""
        for a in range(3):
            if not abs(pose[a]) <= 1e15:
                raise Broken(rule, name, at + 8 * a, f"position {pose[a]}")
        w, x, y, z = pose[3:]
        if not abs((((w * w + x * x) + y * y) + z * z) - 1.0) <= 1e-6:
            raise Broken(rule, name, at + 24, "the orientation has not length 1")

    def check_zero(self, rule, name, at, size, step=1):
        for n, byte in enumerate(bytes(self.data[at:at + size])):
            if byte:
                raise Broken(rule, name, at + n // step * step, "not 0")

    @staticmethod
    def text(raw, allowed):
        """The text before the zeros, None if it is none."""
        text = raw.rstrip(b"\0")
        return text.decode("latin-1") if 1 <= len(text) < len(raw) and all(allowed(c) for c in text) else None

    def check_info(self):
        start, values = next(self.elements("PLAN", PLAN))

        def need(condition, rule, field, text):
            if not condition:
                raise Broken(rule, "PLAN", start + field, text)

        (self.rate, law, field, weighting, self.flags, self.stiffness, self.most_stiffness, self.budget, coupling, self.prewarp,
         self.evaluations, reserved) = values[:12]
        numbers, servo, mount, grip, device, arm = values[12:18], values[18:24], values[24:31], values[31:38], values[38], values[39]
        need(10 <= self.rate <= 1e5, "P201", 0, f"rate {self.rate} Hz")
        need(law in self.LAWS, "P202", 8, f"law {law}")
        need(field in self.FIELDS and (law != 3 or field == 3), "P202", 12, f"field {field} with law {law}")
        need(weighting in self.WEIGHTINGS, "P202", 16, f"weighting {weighting}")
        need(self.flags & ~1 == 0, "P203", 20, f"flags {self.flags:#x}")
        need(0 < self.stiffness < math.inf, "P204", 24, f"stiffness {self.stiffness}")
        need(amount(self.most_stiffness), "P204", 32, f"most_stiffness {self.most_stiffness}")
        need(amount(self.budget) and (self.budget == 0 or weighting == 3), "P204", 40, f"budget {self.budget}")
        need(coupling in self.COUPLINGS, "P205", 48, f"coupling {coupling}")
        self.law, self.field, self.weighting = self.LAWS[law], self.FIELDS[field], self.WEIGHTINGS[weighting]
        self.coupling = self.COUPLINGS[coupling]
        need(self.prewarp <= (coupling == 2), "P206", 52, f"prewarp {self.prewarp}")
        need(1 <= self.evaluations <= 3 if coupling == 4 else self.evaluations == 0, "P206", 56, f"evaluations {self.evaluations}")
        for n, (name, value) in enumerate(zip(self.NUMBERS, numbers)):
            good = 0 < value < math.inf if name in self.HAS[self.coupling] else not any(self.data[start + 64 + 8 * n:start + 72 + 8 * n])
            need(good, "P206", 64 + 8 * n, f"{name} {value} of a coupling {self.coupling}")
        self.numbers = {name: value for name, value in zip(self.NUMBERS, numbers) if name in self.HAS[self.coupling]}
        self.max_force, self.max_torque, self.max_speed, self.hold_time, self.decay_time, self.scale = servo
        for at, value in ((112, self.max_force), (120, self.max_torque), (128, self.max_speed), (152, self.scale)):
            need(0 < value < math.inf, "P207", at, f"limit or scale {value}")
        need(amount(self.hold_time) and self.hold_time <= 3600, "P207", 136, f"hold_time {self.hold_time}")
        need(1e-6 <= self.decay_time <= 3600, "P207", 144, f"decay_time {self.decay_time}")
        self.check_pose("P208", "PLAN", start + 160, mount)
        self.check_pose("P208", "PLAN", start + 216, grip)
        self.device, self.arm = (self.text(raw, lambda c: 0x20 < c < 0x7F) for raw in (device, arm))
        need(self.device, "P209", 272, "device is no name")
        need(self.arm, "P209", 320, "arm is no name")
        need(reserved == 0, "P210", 60, "reserved is not 0")
        self.check_zero("P210", "PLAN", start + 336, 48)

    def check_assets(self):
        entry = self.by_name["ASST"]
        if not 2 <= entry.count <= 4097:
            raise Broken("P301", "TABL", entry.entry_offset, f"{entry.count} assets")
        self.assets = []
        for n, (at, (role, reserved, *pose, content, raw, _)) in enumerate(self.elements("ASST", PLANNED)):
            if role != (2 if n == entry.count - 1 else 1):
                raise Broken("P302", "ASST", at, f"role {role} of asset {n} of {entry.count}")
            name = self.text(raw, lambda c: c >= 0x20 and c not in b"\x7f/\\")
            if not name or name.startswith("."):
                raise Broken("P303", "ASST", at + 96, "name is no file's")
            self.check_pose("P304", "ASST", at + 8, pose)
            if role == 2 and bytes(self.data[at + 8:at + 64]) != struct.pack("<7d", 0, 0, 0, 1, 0, 0, 0):
                raise Broken("P304", "ASST", at + 8, "the dynamic has a pose of its own")
            if reserved:
                raise Broken("P305", "ASST", at + 4, "reserved is not 0")
            self.check_zero("P305", "ASST", at + 352, 32)
            self.assets.append({"role": "dynamic" if role == 2 else "static", "name": raw.rstrip(b"\0").decode("utf-8", "replace"),
                                "content_hash": content.hex()})

    def check_effects(self):
        if "EFCT" in self.by_name and self.by_name["EFCT"].count > 64:
            raise Broken("P401", "TABL", self.by_name["EFCT"].entry_offset, "more than 64 effects")
        self.effects = {}
        for at, (raw, count, reserved, *constants) in self.elements("EFCT", EFFECT):
            kind = self.text(raw, lambda c: c in b"abcdefghijklmnopqrstuvwxyz0123456789-")
            if not kind or kind in self.effects:
                raise Broken("P402", "EFCT", at, "kind is no name, or is there already")
            if count > 24:
                raise Broken("P403", "EFCT", at + 32, f"{count} constants")
            for n, value in enumerate(constants):
                if not math.isfinite(value) if n < count else any(self.data[at + 40 + 8 * n:at + 48 + 8 * n]):
                    raise Broken("P403", "EFCT", at + 40 + 8 * n, f"constant {n} of {kind}: {value}")
            if reserved:
                raise Broken("P404", "EFCT", at + 36, "reserved is not 0")
            self.effects[kind] = constants[:count]

    def check_hand(self):
        if "HAND" in self.by_name and self.by_name["HAND"].count > 2**16:
            raise Broken("P501", "TABL", self.by_name["HAND"].entry_offset, "more than 2^16 keyframes")
        self.hand = []
        for at, (time, *pose, move, reserved, ax, ay, az, ux, uy, uz, angle) in self.elements("HAND", KEYFRAME):
            if not (amount(time) and time <= 1e9 and (not self.hand or time > self.hand[-1][0])):
                raise Broken("P502", "HAND", at, f"time {time}")
            self.check_pose("P503", "HAND", at + 8, pose)
            if move > (1 if self.hand else 0):
                raise Broken("P504", "HAND", at + 64, f"move {move}")
            if reserved:
                raise Broken("P504", "HAND", at + 68, "reserved is not 0")
            if move == 0:
                self.check_zero("P505", "HAND", at + 72, 56, step=8)
            else:
                for a, value in enumerate((ax, ay, az)):
                    if not abs(value) <= 1e15:
                        raise Broken("P505", "HAND", at + 72 + 8 * a, f"turn_about {value}")
                if not abs(((ux * ux + uy * uy) + uz * uz) - 1.0) <= 1e-6:
                    raise Broken("P505", "HAND", at + 96, "turn_axis has not length 1")
                if not abs(angle) <= 1e6:
                    raise Broken("P505", "HAND", at + 120, f"turn_angle {angle}")
            self.hand.append((time, *pose))

    def check_motion(self):
        if "MOVE" in self.by_name and self.by_name["MOVE"].count > 2**16:
            raise Broken("P601", "TABL", self.by_name["MOVE"].entry_offset, "more than 2^16 keyframes")
        self.moves = []
        for at, (time, *pose, asset, reserved) in self.elements("MOVE", MOTION):
            last = self.moves[-1] if self.moves else (-1, 0)
            if not last[1] <= asset < len(self.assets) - 1:
                raise Broken("P602", "MOVE", at + 64, f"asset {asset}")
            if not (amount(time) and time <= 1e9 and (asset > last[1] or time > last[0])):
                raise Broken("P603", "MOVE", at, f"time {time}")
            self.check_pose("P604", "MOVE", at + 8, pose)
            if reserved:
                raise Broken("P605", "MOVE", at + 68, "reserved is not 0")
            self.moves.append((time, asset, *pose))
        if "motion" in self.effects and not self.moves:
            at = self.by_name["EFCT"].offset + 232 * list(self.effects).index("motion")
            raise Broken("P606", "EFCT", at, "a motion without MOVE")
        if self.moves and "motion" not in self.effects:
            raise Broken("P606", "TABL", self.by_name["MOVE"].entry_offset, "MOVE without a motion")

    def summary(self):
        return {**super().summary(), "rate_hz": self.rate, "device": self.device, "arm": self.arm, "law": self.law, "field": self.field,
                "weighting": self.weighting, "coupling": {"kind": self.coupling, "designed": bool(self.flags & 1), **self.numbers},
                "max_force_n": self.max_force, "assets": self.assets,
                "effects": [{"kind": kind, "constants": constants} for kind, constants in self.effects.items()],
                "hand_keyframes": len(self.hand), "motion_keyframes": len(self.moves)}


KINDS = {"voxmap": Voxmap, "pointshell": Pointshell, "plan": Plan}


def read_asset(data):
    """A Voxmap, a Pointshell or a Plan of the file's bytes. Raises Broken."""
    return KINDS[MAGIC.get(bytes(data[:8]), "voxmap")](data)


def open_asset(path):
    """The same from a file. Raises OSError too."""
    with open(path, "rb") as file:
        return read_asset(file.read())


def main(arguments):
    check = "--check" in arguments
    paths = [a for a in arguments if a != "--check"]
    if len(paths) != 1 or paths[0].startswith("--"):
        print(__doc__, file=sys.stdout if "--help" in paths else sys.stderr)
        return 0 if "--help" in paths else 1
    try:
        asset = open_asset(paths[0])
    except OSError as error:
        print(f"read_asset.py: error: {paths[0]}: {error.strerror}", file=sys.stderr)
        return 2
    except Broken as broken:
        if check:
            print(broken)
        else:
            print(f"read_asset.py: error: {paths[0]}: {broken}", file=sys.stderr)
        return 3
    print("OK" if check else json.dumps(asset.summary(), indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
