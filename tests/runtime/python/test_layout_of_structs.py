# SPDX-License-Identifier: MIT
"""What the Python package says of C is what the headers say: a compiler looks at every struct, prototype and constant."""
import ctypes
import os
import pathlib
import subprocess
import unittest

import voxshell
from voxshell import contact, device, library, servo, servo_thread, voxmap

ROOT = pathlib.Path(__file__).resolve().parents[3]
TYPES = {ctypes.c_double: "double", ctypes.c_uint32: "uint32_t", ctypes.c_uint64: "uint64_t", ctypes.c_int64: "int64_t",
         ctypes.c_uint16: "uint16_t", ctypes.c_int: "int",
         ctypes.c_int32: "int32_t", ctypes.c_size_t: "size_t"}
INCLUDES = ["-I", ROOT / "runtime/include", "-I", ROOT / "formats/include"]


def constants():
    """(name in C, number in Python)."""
    for names, prefix in ((contact.LAWS, "CONTACT"), (contact.FIELDS, "CONTACT"), (contact.WEIGHTINGS, "CONTACT"), (servo.COUPLINGS, "COUPLING")):
        for name, number in names.items():
            yield f"VXS_{prefix}_{name.upper().replace('-', '_')}", number
    for flags, prefix in ((contact.ContactFlag, "CONTACT"), (servo.ServoFlag, "SERVO")):
        for flag in flags:
            yield f"VXS_{prefix}_{flag.name}", flag.value
    for name in ("CLOSED", "NO_FIRMWARE", "UNCALIBRATED", "READY", "ARMED", "FAULT", "GONE"):
        yield f"VXS_DEVICE_{name}", getattr(device, name)
    for name in ("FREE", "SURFACE", "INTERIOR"):
        yield f"VXS_CELL_{name}", getattr(voxmap, name)
    for kind in (voxshell.Voxmap, voxshell.Pointshell, voxshell.Plan):
        yield f"VXS_ASSET_{kind.__name__.upper()}", kind.KIND
    yield "VXS_CHANNEL", -71
    yield "VXS_SERVO_THREAD_BINS", servo_thread.BINS


def compiles(lines):
    source = '#include "voxshell/hardware.h"\n#include "voxshell/replay.h"\n#include "voxshell/voxshell.h"\n' + "\n".join(lines) + "\n"
    done = subprocess.run([os.environ.get("VXS_CC", "cc"), "-std=c11", "-Wall", "-Werror", "-fsyntax-only", *INCLUDES, "-x", "c", "-"],
                          input=source, capture_output=True, text=True, check=False)
    return done.stderr if done.returncode else ""


def about(struct):
    name = struct.C_NAME
    yield f'_Static_assert(sizeof({name}) == {ctypes.sizeof(struct)}, "size of {name}");'
    for field, kind in struct._fields_:
        placed = getattr(struct, field)
        yield f'_Static_assert(offsetof({name}, {field}) == {placed.offset}, "{name}.{field}");'
        yield f'_Static_assert(sizeof((({name} *)0)->{field}) == {placed.size}, "{name}.{field}");'
        element = getattr(kind, "_type_", None) if issubclass(kind, ctypes.Array) else kind
        if element in TYPES:
            at = f"(({name} *)0)->{field}" + ("[0]" if element is not kind else "")
            yield f'_Static_assert(_Generic({at}, {TYPES[element]}: 1, default: 0), "type of {name}.{field}");'


class Layout(unittest.TestCase):
    def test_structs(self):
        structs = library.Struct.__subclasses__()
        self.assertGreater(len(structs), 20)
        for struct in structs:
            self.assertEqual(compiles(about(struct)), "", struct)

    def test_prototypes(self):
        self.assertEqual(compiles([library.PROTOTYPES, library.DEVICES]), "")
        self.assertGreater(len([name for name in vars(library.load()) if name.startswith("vxs_")]), 30)

    def test_constants(self):
        known = list(constants())
        self.assertGreater(len(known), 40)
        for name, number in known:
            self.assertEqual(compiles([f'_Static_assert({name} == {number}, "{name}");']), "", name)

    def test_they_would_be_missed(self):
        self.assertRegex(compiles(['_Static_assert(sizeof(vxs_pose) == 48, "size");']), "static assertion failed|static_assert failed")
        self.assertIn("conflicting types", compiles(["double vxs_version(void);"]))


if __name__ == "__main__":
    unittest.main()
