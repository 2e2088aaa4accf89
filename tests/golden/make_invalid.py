#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes files that break exactly one rule each, from the valid goldens: make_invalid.py DIR.

A case names its rule, its golden and an edit. Everything else (offsets, checksums, content hash) is made right
again afterwards, so that a reader that misses the rule accepts the file."""
import hashlib
import os
import struct
import sys
import zlib

VALID = os.path.join(os.path.dirname(os.path.abspath(__file__)), "valid")
NAN, INF = float("nan"), float("inf")

HEADER = {"magic": (0, "8s"), "major": (8, "H"), "minor": (10, "H"), "header_size": (12, "I"), "file_size": (16, "Q"),
          "required": (24, "I"), "optional": (28, "I"), "section_count": (32, "I"), "entry_size": (36, "I"),
          "table_offset": (40, "Q"), "content_hash": (48, "32s"), "source_hash": (80, "32s"), "table_crc": (112, "I"),
          "reserved": (116, "I"), "header_crc": (124, "I")}
ENTRY = {"id": (0, "4s"), "stride": (4, "I"), "count": (8, "Q"), "offset": (16, "Q"), "size": (24, "Q"), "crc": (32, "I"),
         "reserved": (36, "I")}
GRID = {"voxel": (0, "d"), "origin": (8, "q"), "dims": (32, "I"), "layers": (44, "I"), "surface": (48, "Q"),
        "interior": (56, "Q"), "min": (64, "q"), "max": (88, "q"), "step": (112, "d"), "band": (120, "d"), "error": (128, "d"),
        "flags": (136, "I"), "reserved": (140, "I"), "pad": (191, "B")}
SHEL = {"voxel": (0, "d"), "kind": (8, "I"), "points": (12, "I"), "padded": (16, "I"), "clusters": (20, "I"), "area": (24, "d"),
        "gap": (32, "d"), "error": (40, "d"), "center": (48, "d"), "radius": (72, "d"), "cells": (80, "Q"), "pad": (111, "B")}
CLUS = {"center": (0, "f"), "radius": (12, "f"), "first": (16, "I"), "count": (20, "I"), "reserved": (28, "I")}


PLAN = {"rate": (0, "d"), "law": (8, "I"), "field": (12, "I"), "weighting": (16, "I"), "flags": (20, "I"), "stiffness": (24, "d"),
        "most": (32, "d"), "budget": (40, "d"), "coupling": (48, "I"), "prewarp": (52, "I"), "evaluations": (56, "I"),
        "reserved": (60, "I"), "omega0": (64, "d"), "damping": (72, "d"), "gain": (80, "d"), "spring": (88, "d"), "radius": (96, "d"),
        "mass": (104, "d"), "force": (112, "d"), "torque": (120, "d"), "speed": (128, "d"), "hold": (136, "d"), "decay": (144, "d"),
        "scale": (152, "d"), "mount": (160, "d"), "grip": (216, "d"), "device": (272, "48s"), "arm": (320, "16s"), "pad": (336, "B")}
ASST = {"role": (0, "I"), "reserved": (4, "I"), "pose": (8, "d"), "name": (96, "256s"), "pad": (352, "B")}
EFCT = {"kind": (0, "32s"), "count": (32, "I"), "reserved": (36, "I"), "constant": (40, "d")}
HAND = {"time": (0, "d"), "pose": (8, "d"), "move": (64, "I"), "reserved": (68, "I"), "about": (72, "d"), "axis": (96, "d"),
        "angle": (120, "d")}

MOVE = {"time": (0, "d"), "pose": (8, "d"), "asset": (64, "I"), "reserved": (68, "I")}


def round64(n):
    return (n + 63) // 64 * 64


def put(data, fields, name, value, at=0):
    offset, code = fields[name]
    struct.pack_into("<" + code, data, at + offset, value)


class Draft:
    """A file taken apart: sections to edit, and what to overwrite in header, table and bytes after the rest is right."""

    def __init__(self, golden):
        with open(os.path.join(VALID, golden), "rb") as file:
            data = file.read()
        self.header = bytearray(data[:128])
        self.sections = []
        for n in range(struct.unpack_from("<I", data, 32)[0]):
            name, stride, _, offset, size = struct.unpack_from("<4sIQQQ", data, 128 + 40 * n)
            self.sections.append([name.decode(), stride, bytearray(data[offset:offset + size])])
        self.in_header, self.in_table, self.in_bytes, self.whole = {}, {}, {}, None

    def section(self, name):
        return next(s for s in self.sections if s[0] == name)

    def bytes_of(self, name):
        return self.section(name)[2]

    def build(self):
        count = len(self.sections)
        out = bytearray(128 + 40 * count)
        offsets = []
        content = hashlib.sha256()
        for name, stride, body in self.sections:
            out += bytes(round64(len(out)) - len(out))
            offsets.append(len(out))
            out += body
            if name != "META":
                content.update(name.encode("latin-1") + struct.pack("<IQ", stride, len(body) // stride) + body)
        out += bytes(round64(len(out)) - len(out))
        for n, (name, stride, body) in enumerate(self.sections):
            struct.pack_into("<4sIQQQII", out, 128 + 40 * n, name.encode("latin-1"), stride, len(body) // stride, offsets[n],
                             len(body), zlib.crc32(body), 0)
        for (n, field), value in self.in_table.items():
            put(out, ENTRY, field, value, 128 + 40 * n)
        for offset, value in self.in_bytes.items():
            out[offset] = value
        table = out[128:128 + 40 * count]
        out[:128] = self.header
        for field, value in {"file_size": len(out), "section_count": count, "content_hash": content.digest(),
                             "table_crc": zlib.crc32(table), **self.in_header}.items():
            put(out, HEADER, field, value)
        if "header_crc" not in self.in_header:
            put(out, HEADER, "header_crc", zlib.crc32(out[:124]))
        return bytes(self.whole(out) if self.whole else out)


def header(**fields):
    return lambda d: d.in_header.update(fields)


def table(n, **fields):
    return lambda d: d.in_table.update({(n, field): value for field, value in fields.items()})


def grid(name, value, axis=0):
    return lambda d: put(d.bytes_of("GRID"), GRID, name, value, axis * struct.calcsize(GRID[name][1]))


def shel(name, value, axis=0):
    return lambda d: put(d.bytes_of("SHEL"), SHEL, name, value, axis * struct.calcsize(SHEL[name][1]))


def cluster(n, name, value):
    return lambda d: put(d.bytes_of("CLUS"), CLUS, name, value, 32 * n)


def plan(name, value, axis=0):
    return lambda d: put(d.bytes_of("PLAN"), PLAN, name, value, axis * struct.calcsize(PLAN[name][1]))


def asset(n, name, value, axis=0):
    return lambda d: put(d.bytes_of("ASST"), ASST, name, value, 384 * n + axis * struct.calcsize(ASST[name][1]))


def effect(n, name, value, axis=0):
    return lambda d: put(d.bytes_of("EFCT"), EFCT, name, value, 232 * n + axis * struct.calcsize(EFCT[name][1]))


def hand(n, name, value, axis=0):
    return lambda d: put(d.bytes_of("HAND"), HAND, name, value, 128 * n + axis * struct.calcsize(HAND[name][1]))


def move(n, name, value, axis=0):
    return lambda d: put(d.bytes_of("MOVE"), MOVE, name, value, 72 * n + axis * struct.calcsize(MOVE[name][1]))


def value(section, code, n, number):
    return lambda d: struct.pack_into("<" + code, d.bytes_of(section), n * struct.calcsize(code), number)


def resize(section, size):
    """Cuts a section, or lengthens it by zeros."""
    def edit(d):
        body = d.bytes_of(section)
        body[size:] = bytes(max(0, size - len(body)))
    return edit


def restride(section, stride):
    def edit(d):
        d.section(section)[1] = stride
    return edit


def rename(section, name):
    def edit(d):
        d.section(section)[0] = name
    return edit


def insert(n, name, stride=4):
    return lambda d: d.sections.insert(n, [name, stride, bytearray(stride)])


def swap(a, b):
    def edit(d):
        d.sections[a], d.sections[b] = d.sections[b], d.sections[a]
    return edit


def drop(section):
    return lambda d: d.sections.remove(d.section(section))


def whole(change):
    def edit(d):
        d.whole = change
    return edit


def byte(offset, number):
    return lambda d: d.in_bytes.update({offset: number})


def both(*edits):
    def edit(d):
        for e in edits:
            e(d)
    return edit


def second_chunk(d):
    """A further chunk, solid throughout, that should have been an entry of ROOT."""
    grid("dims", 2, 2)(d)
    resize("ROOT", 8)(d)
    value("ROOT", "I", 1, 5)(d)
    d.bytes_of("CHNK").extend(struct.pack("<I", 2) * 512)


def second_brick(state_byte):
    def edit(d):
        value("CHNK", "I", 1, 5)(d)
        d.bytes_of("BRIK").extend(bytes([state_byte]) * 128)
    return edit


MAP, UNIFORM, CHANNELS, CLEARANCE = "one_cell.voxmap", "uniform.voxmap", "channels.voxmap", "clearance.voxmap"
POINT, SHELL, NO_AREA = "one_point.pointshell", "two_clusters.pointshell", "no_area.pointshell"
BARE, PRESSED, MOVED = "bare.plan", "pressed.plan", "moved.plan"
HUGE = 2**64 - 64

CASES = [
    ("C101", MAP, whole(lambda b: b[:127])),
    ("C101", POINT, whole(lambda b: b[:0])),
    ("C102", MAP, header(magic=b"\x89VXQ\r\n\x1a\n")),
    ("C102", POINT, header(magic=b"\x89VXP\n\r\x1a\n")),
    ("C103", MAP, header(major=2)),
    ("C103", POINT, header(major=0)),
    ("C104", MAP, header(header_crc=0)),
    ("C105", MAP, header(required=0x80000000)),
    ("C105", MAP, header(required=1)),
    ("C105", NO_AREA, header(required=3)),
    ("C106", MAP, whole(lambda b: b[:-64])),
    ("C106", POINT, whole(lambda b: b + bytes(64))),
    ("C106", SHELL, whole(lambda b: b[:-1])),
    ("C107", MAP, header(section_count=0)),
    ("C107", MAP, header(section_count=65)),
    ("C107", POINT, header(section_count=2**32 - 1)),
    ("C107", POINT, header(section_count=64)),
    ("C108", MAP, header(header_size=192)),
    ("C108", MAP, header(entry_size=48)),
    ("C108", POINT, header(table_offset=192)),
    ("C109", MAP, header(reserved=1)),
    ("C110", MAP, header(table_crc=0)),
    ("C201", MAP, table(4, id=b"meta")),
    ("C201", MAP, both(insert(4, "XTRA"), table(4, id=b"GRID"))),
    ("C201", POINT, both(insert(9, "XTRA"), table(9, id=b"HEAD"))),
    ("C201", POINT, both(insert(9, "XTRA"), table(9, id=b"TABL"))),
    ("C202", MAP, table(1, count=2)),
    ("C202", MAP, table(1, stride=0)),
    ("C202", MAP, table(1, count=0, size=0)),
    ("C202", POINT, table(1, stride=16, count=2**60 + 4)),
    ("C203", MAP, table(1, offset=64)),
    ("C203", MAP, table(0, offset=HUGE)),
    ("C203", POINT, table(9, count=2**40, size=2**40)),
    ("C203", POINT, table(9, count=HUGE, size=HUGE)),
    ("C203", POINT, both(header(file_size=690), whole(lambda b: b[:690]))),
    ("C204", MAP, table(3, reserved=1)),
    ("C205", MAP, lambda d: d.bytes_of("META").extend(bytes(64)) or table(4, count=15, size=15)(d)),
    ("C206", MAP, insert(5, "XTRA")),
    ("C206", POINT, drop("META")),
    ("C206", MAP, table(4, id=b"XTRA")),
    ("C206", POINT, both(resize("META", 16), restride("META", 2))),
    ("C301", MAP, byte(128 + 40 * 5 + 1, 1)),
    ("C301", POINT, whole(lambda b: b[:-1] + b"\1")),
    ("C302", MAP, table(0, crc=0)),
    ("C302", POINT, table(9, crc=0)),
    ("C303", MAP, header(content_hash=bytes(32))),
    ("M101", MAP, swap(1, 2)),
    ("M101", MAP, drop("BRIK")),
    ("M101", MAP, insert(0, "XTRA")),
    ("M101", CHANNELS, swap(4, 5)),
    ("M101", CHANNELS, insert(4, "XTRA")),
    ("M102", MAP, restride("GRID", 96)),
    ("M102", MAP, restride("BRIK", 64)),
    ("M102", MAP, resize("GRID", 384)),
    ("M102", CHANNELS, restride("DIST", 512)),
    ("M103", CHANNELS, resize("LAYR", 512)),
    ("M103", CHANNELS, resize("DIST", 3072)),
    ("M104", CLEARANCE, drop("CLRX")),
    ("M104", CLEARANCE, drop("CLRV")),
    ("M104", CLEARANCE, drop("CLRC")),
    ("M104", CLEARANCE, resize("CLRX", 12)),
    ("M104", CLEARANCE, resize("CLRC", 12)),
    ("M105", CLEARANCE, both(drop("CLRX"), both(drop("CLRV"), drop("CLRC")))),
    ("M105", CLEARANCE, resize("CLRP", 2048)),
    ("M101", CLEARANCE, swap(4, 5)),
    ("M101", CLEARANCE, swap(6, 7)),
    ("M102", CLEARANCE, restride("CLRV", 2048)),
    ("M102", CLEARANCE, restride("CLRP", 1024)),
    ("M201", MAP, grid("voxel", NAN)),
    ("M201", MAP, grid("voxel", 0.0)),
    ("M201", MAP, grid("voxel", INF)),
    ("M201", MAP, grid("voxel", -0.001)),
    ("M202", MAP, grid("origin", 1)),
    ("M202", MAP, grid("origin", -2**44 - 64, 2)),
    ("M202", MAP, grid("origin", -2**63, 1)),
    ("M203", MAP, grid("dims", 0, 1)),
    ("M204", MAP, grid("dims", 16385, 2)),
    ("M204", MAP, both(grid("origin", 2**44 - 64), grid("dims", 2))),
    ("M205", MAP, both(grid("dims", 16384), grid("dims", 1025, 1))),
    ("M207", MAP, grid("dims", 2, 2)),
    ("M207", MAP, resize("ROOT", 8)),
    ("M208", MAP, grid("flags", 4)),
    ("M208", MAP, grid("reserved", 1)),
    ("M208", MAP, grid("pad", 1)),
    ("M209", MAP, grid("layers", 1)),
    ("M209", CHANNELS, grid("layers", 0)),
    ("M209", CHANNELS, grid("layers", 127)),
    ("M210", MAP, grid("step", 1.0)),
    ("M210", MAP, grid("band", -0.0)),
    ("M210", MAP, grid("error", NAN)),
    ("M210", MAP, grid("flags", 2)),
    ("M210", CHANNELS, grid("step", 0.0)),
    ("M210", CHANNELS, grid("band", NAN)),
    ("M210", CHANNELS, grid("band", 1e-9)),
    ("M210", CHANNELS, grid("band", 1.0)),
    ("M210", CHANNELS, grid("error", -1.0)),
    ("M210", CHANNELS, grid("error", INF)),
    ("M210", CHANNELS, both(grid("step", 1e305), grid("band", INF))),
    ("M211", MAP, grid("surface", 0)),
    ("M301", MAP, value("ROOT", "I", 0, 1)),
    ("M301", MAP, value("ROOT", "I", 0, 3)),
    ("M301", MAP, value("ROOT", "I", 0, 5)),
    ("M301", MAP, value("ROOT", "I", 0, 2**32 - 1)),
    ("M301", MAP, value("ROOT", "I", 0, 2)),
    ("M301", UNIFORM, both(value("ROOT", "I", 0, 4), value("ROOT", "I", 1, 4))),
    ("M302", MAP, both(grid("dims", 2, 2), resize("ROOT", 8))),
    ("M302", MAP, both(grid("dims", 2, 0), resize("ROOT", 8))),
    ("M303", MAP, value("CHNK", "I", 511, 1)),
    ("M303", MAP, value("CHNK", "I", 0, 5)),
    ("M303", MAP, value("CHNK", "I", 1, 4)),
    ("M303", MAP, value("CHNK", "I", 1, 5)),
    ("M304", MAP, second_chunk),
    ("M305", MAP, value("BRIK", "B", 0, 3)),
    ("M305", UNIFORM, value("BRIK", "B", 127, 0xC0)),
    ("M306", MAP, second_brick(0)),
    ("M306", MAP, second_brick(0xAA)),
    ("M307", MAP, grid("surface", 2)),
    ("M307", UNIFORM, grid("interior", 262659)),
    ("M307", MAP, value("CHNK", "I", 9, 2)),
    ("M308", MAP, grid("max", 1, 1)),
    ("M308", UNIFORM, grid("min", -63)),
    ("M308", UNIFORM, grid("min", 2**63 - 1, 2)),
    ("M401", CHANNELS, value("LAYR", "b", 448, 1)),
    ("M401", CHANNELS, value("LAYR", "b", 0, 0)),
    ("M401", CHANNELS, value("LAYR", "b", 1023, 4)),
    ("M401", CHANNELS, value("LAYR", "b", 5, -1)),
    ("M402", CHANNELS, value("DIST", "h", 3, -1)),
    ("M402", CHANNELS, value("DIST", "h", 3, 129)),
    ("M402", CHANNELS, both(grid("flags", 0), value("DIST", "h", 3, -1))),
    ("M402", CHANNELS, both(grid("flags", 0), value("DIST", "h", 448, -32768))),
    ("M501", CLEARANCE, value("CLRX", "I", 0, 0)),
    ("M501", CLEARANCE, value("CLRX", "I", 0, 3)),
    ("M501", CLEARANCE, value("CLRX", "I", 0, 5)),
    ("M501", CLEARANCE, resize("CLRV", 4096)),
    ("M501", CLEARANCE, value("CLRX", "I", 3, 7)),
    ("M502", CLEARANCE, value("CLRV", "b", 0, 0)),
    ("M502", CLEARANCE, value("CLRV", "b", 2000, 1)),
    ("M502", CLEARANCE, value("CLRV", "b", 2000, -128)),
    ("M502", CLEARANCE, value("CLRV", "b", 8191, -1)),
    ("M503", CLEARANCE, value("CLRC", "i", 3, 95)),
    ("M503", CLEARANCE, value("CLRC", "i", 3, 4097)),
    ("M503", CLEARANCE, value("CLRC", "i", 3, -96)),
    ("M503", CLEARANCE, value("CLRC", "i", 0, 96)),
    ("M504", CLEARANCE, value("CLRP", "b", 3, 0)),
    ("M504", CLEARANCE, value("CLRP", "b", 0, 127)),
    ("M504", CLEARANCE, value("CLRP", "b", 4 * 1 + 2, -126)),
    ("M504", CLEARANCE, value("CLRP", "b", 4 * 1 + 2, -128)),
    ("M504", CLEARANCE, value("CLRP", "b", 4 * 3 + 3, 1)),
    ("M504", CLEARANCE, value("CLRP", "b", 4 * 1023 + 3, -2)),
    ("S101", POINT, swap(1, 2)),
    ("S101", POINT, drop("CLUS")),
    ("S101", SHELL, insert(7, "XTRA")),
    ("S101", SHELL, header(required=1)),
    ("S101", NO_AREA, header(required=0)),
    ("S101", NO_AREA, insert(7, "AREA")),
    ("S102", POINT, restride("SHEL", 56)),
    ("S102", POINT, resize("SHEL", 224)),
    ("S102", POINT, restride("AREA", 8)),
    ("S102", SHELL, restride("CLUS", 64)),
    ("S102", NO_AREA, restride("CLUS", 64)),
    ("S103", NO_AREA, insert(8, "AREA")),
    ("S201", POINT, shel("voxel", NAN)),
    ("S201", POINT, shel("voxel", 1e4)),
    ("S202", POINT, shel("kind", 0)),
    ("S202", POINT, shel("kind", 3)),
    ("S203", POINT, shel("points", 0)),
    ("S203", POINT, shel("points", 2**28 + 1)),
    ("S204", POINT, shel("padded", 32)),
    ("S204", SHELL, shel("points", 81)),
    ("S205", POINT, shel("clusters", 2)),
    ("S206", POINT, resize("NRMY", 128)),
    ("S206", SHELL, resize("CLUS", 96)),
    ("S206", NO_AREA, resize("NRMZ", 128)),
    ("S207", POINT, shel("area", NAN)),
    ("S207", NO_AREA, shel("area", -1.0)),
    ("S207", POINT, shel("gap", -1.0)),
    ("S207", POINT, shel("error", INF)),
    ("S207", POINT, shel("center", NAN, 1)),
    ("S207", POINT, shel("center", 2e15, 2)),
    ("S207", POINT, shel("radius", NAN)),
    ("S208", POINT, shel("pad", 1)),
    ("S209", POINT, shel("cells", 0)),
    ("S209", POINT, shel("cells", 2)),
    ("S301", SHELL, value("POSY", "f", 69, NAN)),
    ("S301", SHELL, value("POSZ", "f", 0, -INF)),
    ("S302", SHELL, value("NRMX", "f", 3, 0.6001)),
    ("S302", SHELL, value("NRMZ", "f", 69, NAN)),
    ("S302", SHELL, value("NRMY", "f", 0, 0.0)),
    ("S303", SHELL, value("AREA", "f", 1, -0.25)),
    ("S303", SHELL, value("AREA", "f", 1, NAN)),
    ("S303", POINT, both(value("AREA", "f", 0, -0.0), shel("area", 0.0))),
    ("S304", SHELL, shel("area", 17.50002)),
    ("S304", SHELL, shel("area", 0.0)),
    ("S305", POINT, value("POSX", "f", 15, 0.0)),
    ("S305", POINT, value("NRMX", "f", 1, -0.0)),
    ("S305", NO_AREA, value("NRMZ", "f", 70, 1.0)),
    ("S305", SHELL, value("AREA", "f", 79, 0.25)),
    ("S305", SHELL, value("AREA", "f", 70, -0.0)),
    ("S401", SHELL, cluster(1, "first", 63)),
    ("S401", SHELL, cluster(0, "count", 63)),
    ("S401", SHELL, cluster(1, "count", 16)),
    ("S402", SHELL, cluster(1, "center", NAN)),
    ("S402", SHELL, cluster(1, "radius", INF)),
    ("S402", SHELL, cluster(1, "radius", -1.0)),
    ("S403", SHELL, cluster(0, "reserved", 1)),
    ("S404", SHELL, cluster(0, "radius", 1.9687498807907104)),
    ("S404", SHELL, cluster(1, "center", 4.2)),
    ("S405", SHELL, shel("radius", 2.1562499999999996)),
    ("P101", BARE, swap(0, 1)),
    ("P101", BARE, drop("ASST")),
    ("P101", PRESSED, swap(2, 3)),
    ("P101", PRESSED, insert(2, "XTRA")),
    ("P102", BARE, restride("PLAN", 192)),
    ("P102", BARE, resize("PLAN", 768)),
    ("P102", PRESSED, restride("HAND", 64)),
    ("P102", PRESSED, restride("EFCT", 116)),
    ("P201", BARE, plan("rate", NAN)),
    ("P201", BARE, plan("rate", 9.5)),
    ("P201", BARE, plan("rate", 100001.0)),
    ("P202", BARE, plan("law", 0)),
    ("P202", BARE, plan("law", 5)),
    ("P202", BARE, plan("law", 3)),
    ("P202", BARE, plan("field", 4)),
    ("P202", BARE, plan("weighting", 0)),
    ("P202", BARE, plan("weighting", 4)),
    ("P202", BARE, plan("field", 0)),
    ("P203", BARE, plan("flags", 2)),
    ("P204", BARE, plan("stiffness", 0.0)),
    ("P204", BARE, plan("most", -0.0)),
    ("P204", BARE, plan("most", INF)),
    ("P204", BARE, plan("budget", 1e-5)),
    ("P204", PRESSED, plan("budget", -1e-5)),
    ("P205", BARE, plan("coupling", 0)),
    ("P205", PRESSED, plan("coupling", 1000)),
    ("P206", BARE, plan("prewarp", 1)),
    ("P206", PRESSED, plan("prewarp", 2)),
    ("P206", BARE, plan("evaluations", 1)),
    ("P206", PRESSED, plan("omega0", 0.0)),
    ("P206", PRESSED, plan("damping", NAN)),
    ("P206", PRESSED, plan("gain", INF)),
    ("P206", PRESSED, plan("spring", -0.0)),
    ("P206", BARE, plan("mass", 1.0)),
    ("P206", PRESSED, plan("coupling", 3)),
    ("P206", BARE, plan("coupling", 4)),
    ("P207", BARE, plan("force", 0.0)),
    ("P207", BARE, plan("torque", NAN)),
    ("P207", BARE, plan("speed", INF)),
    ("P207", BARE, plan("hold", -0.0)),
    ("P207", BARE, plan("hold", 3601.0)),
    ("P207", BARE, plan("decay", 0.0)),
    ("P207", BARE, plan("decay", 3601.0)),
    ("P207", BARE, plan("scale", -1.0)),
    ("P208", BARE, plan("mount", NAN, 2)),
    ("P208", BARE, plan("mount", 1.001, 3)),
    ("P208", PRESSED, plan("grip", 2e15)),
    ("P208", PRESSED, plan("grip", 0.0, 3)),
    ("P209", BARE, plan("device", b"")),
    ("P209", BARE, plan("device", b"a b")),
    ("P209", BARE, plan("device", b"x" * 48)),
    ("P209", BARE, plan("arm", b"hand\0x")),
    ("P210", BARE, plan("reserved", 1)),
    ("P210", PRESSED, plan("pad", 1, 47)),
    ("P301", BARE, resize("ASST", 384)),
    ("P301", BARE, resize("ASST", 384 * 4098)),
    ("P302", BARE, asset(0, "role", 2)),
    ("P302", PRESSED, asset(2, "role", 1)),
    ("P302", PRESSED, asset(1, "role", 0)),
    ("P303", BARE, asset(0, "name", b"")),
    ("P303", BARE, asset(0, "name", b"../a.voxmap")),
    ("P303", BARE, asset(0, "name", b"a/a.voxmap")),
    ("P303", BARE, asset(0, "name", b"a\\a.voxmap")),
    ("P303", BARE, asset(1, "name", b".b")),
    ("P303", BARE, asset(1, "name", b"b\n")),
    ("P303", PRESSED, asset(1, "name", b"y" * 256)),
    ("P304", BARE, asset(0, "pose", INF)),
    ("P304", PRESSED, asset(1, "pose", 0.61, 3)),
    ("P304", BARE, asset(1, "pose", 0.5)),
    ("P304", BARE, asset(1, "pose", -0.0, 1)),
    ("P305", BARE, asset(0, "reserved", 1)),
    ("P305", BARE, asset(1, "pad", 1, 31)),
    ("P401", PRESSED, resize("EFCT", 232 * 65)),
    ("P402", PRESSED, effect(0, "kind", b"")),
    ("P402", PRESSED, effect(0, "kind", b"Start")),
    ("P402", PRESSED, effect(1, "kind", b"start-inside")),
    ("P402", PRESSED, effect(1, "kind", b"soft-start\0s")),
    ("P403", PRESSED, effect(0, "count", 25)),
    ("P403", PRESSED, effect(1, "constant", NAN)),
    ("P403", PRESSED, effect(1, "constant", -0.0, 1)),
    ("P403", PRESSED, effect(0, "constant", 1.0, 23)),
    ("P404", PRESSED, effect(1, "reserved", 1)),
    ("P501", PRESSED, resize("HAND", 128 * (2**16 + 1))),
    ("P502", PRESSED, hand(0, "time", -0.0)),
    ("P502", PRESSED, hand(1, "time", 0.0)),
    ("P502", PRESSED, hand(2, "time", 2e9)),
    ("P503", PRESSED, hand(0, "pose", NAN)),
    ("P503", PRESSED, hand(2, "pose", 0.5, 6)),
    ("P504", PRESSED, hand(0, "move", 1)),
    ("P504", PRESSED, hand(1, "move", 2)),
    ("P504", PRESSED, hand(2, "reserved", 1)),
    ("P505", PRESSED, hand(1, "about", -0.0, 2)),
    ("P505", PRESSED, hand(1, "angle", 1.0)),
    ("P505", PRESSED, hand(2, "about", NAN)),
    ("P505", PRESSED, hand(2, "axis", 0.5, 1)),
    ("P505", PRESSED, hand(2, "angle", INF)),
    ("P601", MOVED, resize("MOVE", 72 * (2**16 + 1))),
    ("P602", MOVED, move(0, "asset", 2)),
    ("P602", MOVED, move(1, "asset", 0)),
    ("P603", MOVED, move(0, "time", -1.0)),
    ("P603", MOVED, move(0, "time", -0.0)),
    ("P603", MOVED, move(1, "time", 0.0)),
    ("P603", MOVED, move(1, "time", NAN)),
    ("P604", MOVED, move(1, "pose", INF, 1)),
    ("P604", MOVED, move(0, "pose", 0.5, 3)),
    ("P605", MOVED, move(1, "reserved", 1)),
    ("P606", MOVED, drop("MOVE")),
    ("P606", MOVED, effect(0, "kind", b"motions")),
]

# 2^28 bricks are a file of 32 GiB.
NOT_MADE = {"M206"}


def cases():
    """(file name, rule, bytes) of every broken file."""
    seen = {}
    for rule, golden, edit in CASES:
        seen[rule] = seen.get(rule, 0) + 1
        draft = Draft(golden)
        edit(draft)
        yield f"{rule}-{seen[rule]}{os.path.splitext(golden)[1]}", rule, draft.build()


def main(arguments):
    if len(arguments) != 1:
        print("make_invalid.py DIR", file=sys.stderr)
        return 1
    os.makedirs(arguments[0], exist_ok=True)
    for name, _, data in cases():
        with open(os.path.join(arguments[0], name), "wb") as file:
            file.write(data)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
