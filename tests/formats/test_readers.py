#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The C reader and the Python reader give the same verdict: test_readers.py PRINT_RULE INVALID_DIR.

On every golden, on a file per rule (written to INVALID_DIR), on every prefix of every golden, on damaged header, table
and section bytes with and without mended checksums. The verdict is rule, section and offset."""
import hashlib
import os
import random
import re
import struct
import subprocess
import sys
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..")
sys.path += [os.path.join(ROOT, "formats", "reference"), os.path.join(ROOT, "tests", "golden")]

import make_invalid  # noqa: E402
import make_odd  # noqa: E402
import read_asset  # noqa: E402

BYTES = (0, 1, 0x7F, 0xFF)
SCRAMBLED = 1000  # files per golden


def by_python(data):
    try:
        read_asset.read_asset(data)
    except read_asset.Broken as broken:
        return f"{broken.rule} {broken.section} {broken.offset}"
    return "OK"


def by_c(program, files):
    records = b"".join(struct.pack("<I", len(data)) + data for data in files)
    run = subprocess.run([program], input=records, stdout=subprocess.PIPE, check=True)
    lines = run.stdout.decode("latin-1").splitlines()
    assert len(lines) == len(files), f"print_rule stopped after {len(lines)} of {len(files)} files"
    return lines


def mend(data):
    """All checksums and the content hash made right, as far as the table can be followed."""
    data = bytearray(data)
    count = min(struct.unpack_from("<I", data, 32)[0], 64, (len(data) - 128) // 40)
    content = hashlib.sha256()
    for at in range(128, 128 + 40 * count, 40):
        name, stride, elements, offset, size = struct.unpack_from("<4sIQQQ", data, at)
        body = bytes(data[offset:offset + size]) if offset + size <= len(data) else b""
        struct.pack_into("<I", data, at + 32, zlib.crc32(body))
        if name != b"META":
            content.update(name + struct.pack("<IQ", stride, elements) + body)
    data[48:80] = content.digest()
    struct.pack_into("<I", data, 112, zlib.crc32(data[128:128 + 40 * count]))
    struct.pack_into("<I", data, 124, zlib.crc32(data[:124]))
    return bytes(data)


def prefixes(data):
    for length in range(len(data)):
        yield f"first {length} bytes", data[:length]


def damaged(data, offsets, change=bytes):
    for offset in offsets:
        for number in BYTES:
            if data[offset] != number:
                yield f"byte {offset} = {number:#x}", change(data[:offset] + bytes([number]) + data[offset + 1:])


def section_bytes(data):
    """Offsets worth damaging: whole small sections, every 13th byte of large ones."""
    for section in read_asset.read_asset(data).sections[:-1]:
        yield from range(section.offset, section.offset + section.size, 1 if section.size <= 192 else 13)


def scrambled(data, count):
    """Several bytes of the table and the sections changed at once: the first broken rule must be the same one."""
    dice = random.Random(20261122)
    for n in range(count):
        broken = bytearray(data)
        for _ in range(dice.randint(2, 5)):
            offset = dice.choice((dice.randrange(8, len(data)), dice.randrange(8, min(1024, len(data)))))
            broken[offset] = dice.choice((0, 1, 2, 3, 4, 5, 0x7F, 0x80, 0xFF, dice.randrange(256)))
        yield f"scrambled {n}", mend(bytes(broken))


def compare(program, what, named):
    named = list(named)
    verdicts = by_c(program, [data for _, data in named])
    rules = set()
    for (name, data), c in zip(named, verdicts):
        python = by_python(data)
        rules.add(python.split()[0])
        if python.startswith("C303"):  # the one rule that a real-time reader leaves out
            python = "OK"
        assert c == python, f"{what}, {name}: C says {c!r}, Python says {python!r}"
    print(f"{what}: {len(named)} files, verdicts {' '.join(sorted(rules))}")
    return rules


def ids_of_the_specs():
    ids = set()
    for page in ("container.md", "voxmap.md", "pointshell.md", "plan.md"):
        with open(os.path.join(ROOT, "formats", page), encoding="utf-8") as file:
            ids |= set(re.findall(r"^\| ([CMPS]\d{3}) \|", file.read(), re.MULTILINE))
    return ids


def main(program, invalid):
    made = list(make_invalid.cases())
    os.makedirs(invalid, exist_ok=True)
    for name, rule, data in made:
        with open(os.path.join(invalid, name), "wb") as file:
            file.write(data)
        verdict = by_python(data)
        assert verdict.split()[0] == rule, f"{name}: Python says {verdict}"
    compare(program, "one rule broken", [(name, data) for name, _, data in made])
    odd = list(make_odd.invalid())
    for name, rule, data in odd:
        assert by_python(data).split()[0] == rule, f"{name}: Python says {by_python(data)}"
    compare(program, "odd ones", [(name, data) for name, _, data in odd])
    assert compare(program, "odd, but valid", make_odd.valid()) == {"OK"}
    covered = {rule for _, rule, _ in made} | make_invalid.NOT_MADE
    assert covered == ids_of_the_specs(), f"rules without a file, or the reverse: {covered ^ ids_of_the_specs()}"

    for name in sorted(os.listdir(make_invalid.VALID)):
        with open(os.path.join(make_invalid.VALID, name), "rb") as file:
            data = file.read()
        assert mend(data) == data
        assert compare(program, name, [(name, data)]) == {"OK"}
        assert compare(program, f"{name} prefixes", prefixes(data)) == {"C101", "C106"}
        table_end = 128 + 40 * struct.unpack_from("<I", data, 32)[0]
        compare(program, f"{name} header and table", damaged(data, range(table_end)))
        compare(program, f"{name} header and table, mended", damaged(data, range(table_end), mend))
        compare(program, f"{name} sections, mended", damaged(data, section_bytes(data), mend))
        compare(program, f"{name} scrambled, mended", scrambled(data, SCRAMBLED))


if __name__ == "__main__":
    main(*sys.argv[1:])
