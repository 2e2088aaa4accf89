# SPDX-License-Identifier: MIT
"""Devices of the library of its own: hardware (voxshell/hardware.h), and one that moves as it once did (voxshell/replay.h)."""
import ctypes
import os

import numpy as np

from .device import Device
from .library import Memory, Error, Struct, load_devices, need
from .pose import Pose


class ReplayRow(Struct):
    """time [s], growing; pose; buttons."""

    C_NAME = "vxs_replay_row"
    _fields_ = [("time", ctypes.c_double), ("pose", Pose), ("buttons", ctypes.c_uint32), ("reserved", ctypes.c_uint32)]


REPLAY_ROW = np.dtype(ReplayRow)


class ReplayConfig(Struct):
    C_NAME = "vxs_replay_config"
    _fields_ = [("struct_size", ctypes.c_uint32), ("reserved", ctypes.c_uint32), ("rows", ctypes.c_void_p), ("row_count", ctypes.c_size_t),
                ("sample_time", ctypes.c_double)]

    @classmethod
    def default(cls):
        return _default(cls)


class HardwareKind(Struct):
    """name, summary, wires; is_built, or lacks_text: what for."""

    C_NAME = "vxs_hardware_kind"
    _fields_ = [("name", ctypes.c_char_p), ("summary", ctypes.c_char_p), ("wires", ctypes.c_uint32), ("is_built", ctypes.c_uint32),
                ("lacks_text", ctypes.c_char_p)]


class HardwareConfig(Struct):
    """address, is_in_place, rate_hz, haply_setup, haply_links ...: voxshell/hardware.h has what each is, and its default."""

    C_NAME = "vxs_hardware_config"
    _fields_ = [("struct_size", ctypes.c_uint32), ("is_in_place", ctypes.c_uint32), ("address", ctypes.c_char_p), ("firmware", ctypes.c_char_p),
                ("units_per_nm", ctypes.c_double), ("haply_setup", ctypes.c_uint32), ("haply_links", ctypes.c_double * 3),
                *[(name, ctypes.c_double) for name in ("torque_gain", "rate_hz", "max_speed", "linear_speed", "angular_speed")]]

    @classmethod
    def default(cls):
        return _default(cls)


def _default(config):
    made = config()
    getattr(load_devices(), f"{config.C_NAME}_default")(ctypes.byref(made))
    if made.struct_size != ctypes.sizeof(config):
        raise ImportError(f"{load_devices()._name}: {config.C_NAME} has another size there than here")
    return made


class ReplayDevice(Device):
    """Moves as rows say, on virtual time, one sample an exchange; what it is told to render is not felt. Past the last row it stays.

    rows    an array of REPLAY_ROW, or a file: a recording, or a CSV with t_s, x_m, y_m, z_m (voxshell/replay.h)
    rate    samples a second [Hz]

    Raises Error (VXS_CORRUPT: a field that is no finite number; VXS_PARAM: times that do not grow), OSError for the file.
    """

    def __init__(self, rows, rate=1000.0):
        rows = _parsed(rows) if isinstance(rows, (str, os.PathLike)) else np.array(rows, dtype=REPLAY_ROW)
        config = ReplayConfig.default()
        config.rows, config.row_count, config.sample_time = rows.ctypes.data, len(rows), 1 / rate
        memory, opened = Memory(load_devices().vxs_replay_memory()), ctypes.c_void_p()
        need(load_devices().vxs_replay_open(memory.address, memory.size, ctypes.byref(config), ctypes.byref(opened)), "replay")
        super().__init__(opened.value, (memory, rows))


def _parsed(path):
    with open(path, "rb") as file:
        data = file.read()
    count, line = ctypes.c_size_t(), ctypes.c_size_t()

    def parse(rows, most):
        code = load_devices().vxs_replay_parse(data, len(data), rows, most, ctypes.byref(count), ctypes.byref(line))
        if code:
            raise Error(code, f"{os.fspath(path)}, line {line.value}" if line.value else os.fspath(path))

    parse(None, 0)
    rows = np.zeros(count.value, dtype=REPLAY_ROW)
    parse(rows.ctypes.data, len(rows))
    return rows


def hardware_names():
    """Of the kinds that this library can drive: ["haply", "hvlink", "spacemouse"]."""
    names, n = [], 0
    while load_devices().vxs_hardware_kind_at(n):
        kind = HardwareKind.from_address(load_devices().vxs_hardware_kind_at(n))
        if kind.is_built:
            names.append(kind.name.decode())
        n += 1
    return names


class HardwareDevice(Device):
    """A device that is hardware: an I/O thread of C's owns its wire. None was tried on hardware by us.

    kind       hardware_names()
    address    "/dev/ttyACM0", "/dev/hidraw0", "VVVV:PPPP"; None: the first that the kind knows
    more       fields of HardwareConfig: rate_hz=1000, is_in_place=1 (haply), ...

    Raises ValueError for a kind or a field that is none, Error as vxs_hardware_open(): VXS_NO_DEVICE, VXS_ACCESS, VXS_BUSY, VXS_TIMEOUT ...
    """

    def __init__(self, kind, address=None, **more):
        found = load_devices().vxs_hardware_kind_named(kind.encode())
        if not found:
            raise ValueError(f"device '{kind}': there are {', '.join(hardware_names())}")
        config = HardwareConfig.default()
        config.address = None if address is None else os.fsencode(address)
        for name, value in more.items():
            if name not in (field[0] for field in HardwareConfig._fields_[1:]):
                raise ValueError(f"{name}: a device's config has {', '.join(field[0] for field in HardwareConfig._fields_[1:])}")
            if name == "haply_links":
                value = (ctypes.c_double * 3)(*value)
            setattr(config, name, os.fsencode(value) if name in ("address", "firmware") and value is not None else value)
        memory, opened = Memory(load_devices().vxs_hardware_memory()), ctypes.c_void_p()
        code = load_devices().vxs_hardware_open(memory.address, memory.size, found, ctypes.byref(config), ctypes.byref(opened))
        need(code, kind if address is None else f"{kind} at {os.fsdecode(address)}")
        super().__init__(opened.value, memory)
