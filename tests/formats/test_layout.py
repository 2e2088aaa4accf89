#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The tables of the format pages are the structs of the C headers: test_layout.py --compiler CC.

Takes every table under a heading "### `struct`, N bytes" and lets a compiler compare offset, size and type of each field,
that nothing is left out, and that the fields fill the struct. The byte listings of the pages are the goldens they name."""
import argparse
import os
import re
import subprocess
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PAGES = ("container", "voxmap", "pointshell", "plan")
TYPES = {"u8": "uint8_t", "i8": "int8_t", "u16": "uint16_t", "u32": "uint32_t", "u64": "uint64_t", "i64": "int64_t", "f32": "float",
         "f64": "double"}
CONSTANTS = {"VXS_CONTAINER_MAX_SECTIONS": "64", "VXS_VOXMAP_MAX_CELLS": "1 << 20", "VXS_VOXMAP_MAX_ROOT": "1 << 24",
             "VXS_VOXMAP_MAX_BRICKS": "1 << 28", "VXS_VOXMAP_MAX_INDEX": "INT64_C(1) << 44", "VXS_VOXMAP_MAX_LAYERS": "126",
             "VXS_VOXMAP_ENTRY_FIRST": "4",
             "VXS_VOXMAP_CLEARANCE_BLOCKS": "16 * 16 * 16", "VXS_VOXMAP_CLEARANCE_BEYOND": "127",
             "VXS_VOXMAP_PLANE_REACH": "8", "VXS_VOXMAP_PLANE_STEP": "16", "VXS_VOXMAP_PLANE_NORMAL": "127",
             "VXS_VOXMAP_CLEARANCE_LEAST": "96", "VXS_VOXMAP_CLEARANCE_MOST": "4096", "VXS_POINTSHELL_LANES": "16", "VXS_POINTSHELL_CLUSTER_POINTS": "64",
             "VXS_POINTSHELL_MAX_POINTS": "1 << 28", "VXS_PLAN_MAX_STATICS": "4096", "VXS_PLAN_MAX_EFFECTS": "64", "VXS_PLAN_MAX_CONSTANTS": "24",
             "VXS_PLAN_MAX_KEYFRAMES": "1 << 16", "VXS_PLAN_NAME_SIZE": "256", "VXS_CELL_SURFACE": "1", "VXS_CELL_INTERIOR": "2"}


def tables(page):
    """(struct, bytes, [(offset, size, type, name)]) of each table of a page."""
    with open(os.path.join(ROOT, "formats", page + ".md"), encoding="utf-8") as file:
        for part in re.split(r"^### ", file.read(), flags=re.MULTILINE)[1:]:
            heading = re.match(r"`(\w+)`, (\d+) bytes", part)
            if heading:
                rows = re.findall(r"^\| (\d+) \| (\d+) \| ([a-z]\d+(?:\[\d+\])?) \| (\w+) \|", part.split("\n#")[0], re.MULTILINE)
                yield heading[1], int(heading[2]), [(int(o), int(s), t, n) for o, s, t, n in rows]


def assertions(struct, size, rows):
    yield f"sizeof({struct}) == {size}"
    end = 0
    for offset, length, kind, name in rows:
        element = TYPES[kind.split("[")[0]]
        count = int(kind[kind.index("[") + 1:-1]) if "[" in kind else 1
        field = f"(({struct} *)0)->{name}"
        assert offset == end, f"{struct}.{name}: the table leaves out bytes {end} to {offset}"
        end = offset + length
        yield f"offsetof({struct}, {name}) == {offset}"
        yield f"sizeof({field}) == {length}"
        yield f"sizeof({field}) == {count} * sizeof({element})"
        yield f"_Generic(({field}){'[0]' if '[' in kind else ''}, {element}: 1, default: 0)"
    assert end == size, f"{struct}: the table ends at {end} of {size}"


def listed_bytes(listing):
    """The file that a listing "offset  bytes  text" shows: ".." repeats the line before up to the next offset, and
    "(N bytes 0)" means what it says."""
    data, line_before = bytearray(), b""
    for line in listing.strip().splitlines():
        zeros = re.search(r"\((\d+) bytes 0\)$", line)
        if line.strip() == "..":
            continue
        offset = int(line[:4], 16)
        while len(data) < offset:
            data += line_before
        assert len(data) == offset, f"the listing leaves out bytes before {line!r}"
        line_before = bytes(int(zeros[1])) if zeros else bytes.fromhex(line[6:54])
        data += line_before
    return data


def check_listing(page):
    with open(os.path.join(ROOT, "formats", page + ".md"), encoding="utf-8") as file:
        name, listing = re.search(r"^\[`(\w+\.(?:voxmap|pointshell|plan))`\]\(.*?```\n(.*?)```", file.read(), re.MULTILINE | re.DOTALL).groups()
    with open(os.path.join(ROOT, "tests", "golden", "valid", name), "rb") as file:
        assert file.read() == listed_bytes(listing), f"{page}.md lists other bytes than {name} has"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--compiler", default="cc")
    compiler = parser.parse_args().compiler
    lines = [f'#include "voxshell/format/{page}.h"' for page in PAGES]
    structs = []
    for page in PAGES:
        for struct, size, rows in tables(page):
            structs.append(struct)
            lines += [f'_Static_assert({a}, "{struct}");' for a in assertions(struct, size, rows)]
    lines += [f'_Static_assert({name} == ({number}), "{name}");' for name, number in CONSTANTS.items()]
    assert structs == ["vxs_container_header", "vxs_container_section", "vxs_voxmap_grid", "vxs_voxmap_plane", "vxs_pointshell_info",
                       "vxs_pointshell_cluster", "vxs_plan_info", "vxs_plan_asset", "vxs_plan_effect", "vxs_plan_keyframe",
                       "vxs_plan_motion"], structs
    with tempfile.TemporaryDirectory() as folder:
        source = os.path.join(folder, "layout.c")
        with open(source, "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
        subprocess.run([compiler, "-std=c11", "-Wall", "-Werror", "-fsyntax-only", "-I", os.path.join(ROOT, "formats", "include"),
                        source], check=True)
    check_listing("voxmap")
    check_listing("pointshell")
    check_listing("plan")
    print(f"{len(structs)} structs, {len(lines)} lines compared")


if __name__ == "__main__":
    main()
