# SPDX-License-Identifier: MIT
"""Any asset file, mapped and checked (voxshell/asset.h, formats/container.md)."""
import ctypes
import json
import os
import struct

import numpy as np

from .library import Error, Struct, load


class AssetConfig(Struct):
    C_NAME = "vxs_asset_config"
    _fields_ = [(name, ctypes.c_uint32) for name in ("struct_size", "kind", "mode", "skip_checksums", "trusted")]


class AssetView(Struct):
    C_NAME = "vxs_asset"
    _fields_ = [("data", ctypes.c_void_p), ("size", ctypes.c_uint64), ("kind", ctypes.c_uint32),
                ("version_major", ctypes.c_uint16), ("version_minor", ctypes.c_uint16), ("mapped_size", ctypes.c_uint64)]


class AssetIssue(Struct):
    C_NAME = "vxs_asset_issue"
    _fields_ = [("letter", ctypes.c_char), ("rule", ctypes.c_uint32), ("section", ctypes.c_uint32), ("offset", ctypes.c_uint64),
                ("text", ctypes.c_char_p), ("system_error", ctypes.c_int), ("file_major", ctypes.c_uint16),
                ("file_minor", ctypes.c_uint16), ("reader_major", ctypes.c_uint16), ("reader_minor", ctypes.c_uint16)]


class _Mapping:
    """Closes the asset when nothing looks at its bytes any more."""

    def __init__(self, view):
        self.view = view

    def __del__(self, close=load().vxs_asset_close, byref=ctypes.byref):
        close(byref(self.view))


class Asset:
    """A file that breaks no rule of its format. Opening checks all of it once, in C.

    path    of the file; it must not be shortened or written while it is mapped
    copy    read it into memory instead: independent of the file from then on

    Raises Error with the first broken rule, its section and offset; OSError for a file that cannot be read.
    Arrays that come from here are views of the mapped bytes, read-only; they keep the mapping alive by themselves.
    """

    KIND = 0

    def __init__(self, path, copy=False):
        self.path = os.fspath(path)
        config = AssetConfig.default()
        config.kind, config.mode = self.KIND, int(bool(copy))
        self._open("vxs_asset_open", os.fsencode(self.path), config)

    @classmethod
    def from_bytes(cls, data):
        """The same from bytes, which are copied."""
        made = cls.__new__(cls)
        made.path = "<bytes>"
        made._room = np.zeros(len(data) + 63, dtype=np.uint8)
        start = -made._room.ctypes.data % 64
        made._room[start:start + len(data)] = np.frombuffer(data, dtype=np.uint8)
        config = AssetConfig.default()
        config.kind = cls.KIND
        made._open("vxs_asset_from_memory", made._room.ctypes.data + start, len(data), config)
        return made

    def _open(self, function, *arguments):
        *place, config = arguments
        self.view, issue = AssetView(), AssetIssue()  # the view: vxs_asset
        code = getattr(load(), function)(*place, ctypes.byref(config), ctypes.byref(self.view), ctypes.byref(issue))
        if code and issue.system_error:
            raise OSError(issue.system_error, os.strerror(issue.system_error), self.path)
        if code:
            rule = f"{issue.letter.decode()}{issue.rule}" if issue.rule else None
            section = struct.pack("<I", issue.section).decode("latin-1")
            raise Error(code, self.path, rule, section, issue.offset, (issue.text or b"").decode())
        self._bytes = (ctypes.c_uint8 * self.view.size).from_address(self.view.data)
        self._bytes.mapping = _Mapping(self.view)
        self._bytes.room = getattr(self, "_room", None)
        self.bytes = np.frombuffer(memoryview(self._bytes).toreadonly(), dtype=np.uint8)  #: the whole file, a view
        count = self._number("<I", 32)
        table = self.bytes[128:128 + 40 * count].view(
            [("id", "S4"), ("stride", "<u4"), ("count", "<u8"), ("offset", "<u8"), ("size", "<u8"), ("crc", "<u4"), ("reserved", "<u4")])
        self._table = {row["id"].decode(): row for row in table}
        self._read()

    def _read(self):
        """What a kind of asset adds."""

    def _number(self, code, offset):
        return struct.unpack_from(code, self.bytes, offset)[0]

    @property
    def version(self):
        """(major, minor) of the format."""
        return self.view.version_major, self.view.version_minor

    @property
    def content_hash(self):
        """SHA-256 of the content, hex; what a plan knows its assets by."""
        return self.bytes[48:80].tobytes().hex()

    @property
    def source_hash(self):
        """SHA-256 of the file that the asset was made of, hex."""
        return self.bytes[80:112].tobytes().hex()

    @property
    def sections(self):
        """Names in the file's order: ["GRID", "ROOT", ...]."""
        return list(self._table)

    @property
    def meta(self):
        """What the tools noted (version, options): a dict; for people, no part of the content."""
        return json.loads(self.section("META").tobytes())

    def section(self, name, dtype=np.uint8, shape=(-1,)):
        """A section's bytes as an array, a view. Raises KeyError for one that is not there."""
        row = self._table[name]
        start, size = int(row["offset"]), int(row["size"])
        return self.bytes[start:start + size].view(dtype).reshape(shape)

    def __repr__(self):
        return f"<{type(self).__name__} {self.path}>"
