#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Every check of the C readers matters: mutate_checks.py [--compiler CC] [--every N] [--list].

Each condition of asset_check*.c is made true and false in turn: a comparison, a part of an "and" or "or", an "if" as a
whole; a loop's bound false only. All of them are compiled into one program, which is told by a number which one is to be wrong. A mutant that gives
all the files of test_readers.py the right verdicts survived: a check that no test would miss."""
import argparse
import os
import re
import struct
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..")
SOURCE = os.path.join(ROOT, "runtime", "src")
sys.path += [HERE, os.path.join(ROOT, "tests", "golden")]

import make_invalid  # noqa: E402
import make_odd  # noqa: E402
import test_readers  # noqa: E402

CHECKERS = ("asset_check.c", "asset_check_voxmap.c", "asset_check_pointshell.c", "asset_check_plan.c")

# Mutants that no file can tell from the original: "file:condition:value" -> why.
SAME = {
    "asset_check_voxmap.c:m->section[BRIK]->count > max_bricks:0": "a file of 32 GiB",
}

TOKEN = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*|[A-Za-z_]\w*|\d[\w.+-]*|'
                   r'->|<<=|>>=|&&|\|\||[<>=!]=|<<|>>|[-+*/%&|^]=|\+\+|--|\S', re.DOTALL | re.MULTILINE)
OPEN, CLOSE = {"(", "[", "{"}, {")", "]", "}"}
COMPARE = {"<", ">", "<=", ">=", "==", "!="}
ENDS = {";", ",", "?", ":", "=", "return", "{", "}", "+=", "|="}


def tokens_of(text):
    found = [(m.start(), m.end(), m.group()) for m in TOKEN.finditer(text)]
    return [t for t in found if not t[2].startswith(("/*", "//")) and not t[2].lstrip().startswith("#")]


def reach(tokens, at, step, stops):
    """The last token of the operand that begins beside token `at`."""
    depth, last = 0, at
    n = at + step
    outer, inner = (CLOSE, OPEN) if step > 0 else (OPEN, CLOSE)
    while 0 <= n < len(tokens):
        text = tokens[n][2]
        if depth == 0 and (text in outer or text in stops):
            break
        depth += (text in inner) - (text in outer)
        last = n
        n += step
    return last


def conditions(text):
    """(start, end, value) of all that is to be made a constant."""
    tokens = tokens_of(text)
    spans, bounds = set(), set()
    for n, (_, _, token) in enumerate(tokens):
        if token in ("for", "while"):
            bounds.update(range(n, reach(tokens, n + 1, 1, set()) + 2))

    def add(first, last, values):
        spans.update((tokens[first][0], tokens[last][1], value) for value in values)

    for n, (_, _, token) in enumerate(tokens):
        if token in COMPARE:
            stops = ENDS | {"&&", "||", "&", "|"}
            add(reach(tokens, n, -1, stops), reach(tokens, n, 1, stops), (0,) if n in bounds else (0, 1))
        elif token in ("&&", "||") and not (n in bounds and token == "&&"):
            stops = ENDS | {"||"} | ({"&&"} if token == "&&" else set())
            neutral = 1 if token == "&&" else 0
            add(reach(tokens, n, -1, stops), n - 1, (neutral,))
            add(n + 1, reach(tokens, n, 1, stops), (neutral,))
        elif token == "if":
            add(n + 2, reach(tokens, n + 1, 1, set()), (0,))
    # A "for" declares before its first semicolon, and what a static table or an enum says is no condition.
    return sorted(s for s in spans if "static" not in text[s[0]:s[1]])


def mutated(text, first):
    """The source with a switch around each condition, and the conditions by number, from `first` on."""
    spans = conditions(text)
    inserts = []
    for number, (start, end, value) in enumerate(spans, first):
        inserts.append((start, 1, -end, f"MUT({number}, {value}, ("))
        inserts.append((end, 0, -start, "))"))
    out, at = [], 0
    for position, _, _, piece in sorted(inserts):
        out += [text[at:position], piece]
        at = position
    return "".join(out) + text[at:], spans


HEADER = """
#include <stdint.h>
extern int vxsi_mutant;
#define MUT(number, value, condition) (vxsi_mutant == (number) ? (value) : !!(condition))
"""

# Records of verdicts (as it is, as a voxmap, without checksums, trusted) and a file; exit status 1 at the first other verdict.
PROGRAM = r"""
#include "asset_check.h"
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
int vxsi_mutant;
static void judge(const uint8_t *data, uint32_t length, uint32_t kind, int skip, int trusted, char verdict[64])
{
    vxsi_check check = {.data = data, .size = length, .skip_checksums = skip, .trusted = trusted};
    vxs_asset asset;
    memset(verdict, 0, 64);
    vxs_result result = vxsi_check_asset(&check, kind, &asset);
    if (result == VXS_OK)
        snprintf(verdict, 64, "OK %d %s", (int)asset.kind, check.issue.text);
    else
        snprintf(verdict, 64, "%d %c%u %x %llu", (int)result, check.issue.letter ? check.issue.letter : '-', (unsigned)check.issue.rule,
                 (unsigned)check.issue.section, (unsigned long long)check.issue.offset);
}
int main(int count, char **arguments)
{
    struct stat status;
    int fd = open(arguments[1], O_RDONLY);
    fstat(fd, &status);
    size_t size = (size_t)status.st_size, at = 0;
    const uint8_t *data = mmap(NULL, size, PROT_READ, MAP_SHARED, fd, 0);
    FILE *out = count > 3 ? fopen(arguments[3], "wb") : NULL;
    vxsi_mutant = atoi(arguments[2]);
    while (at < size) {
        uint32_t length;
        char verdict[4][64];
        memcpy(&length, data + at + 256, 4);
        judge(data + at + 320, length, VXS_ASSET_ANY, 0, 0, verdict[0]);
        judge(data + at + 320, length, VXS_ASSET_VOXMAP, 0, 0, verdict[1]);
        judge(data + at + 320, length, VXS_ASSET_ANY, 1, 0, verdict[2]);
        judge(data + at + 320, length, VXS_ASSET_ANY, 1, 1, verdict[3]);
        if (out) fwrite(verdict, 1, sizeof verdict, out);
        else if (memcmp(verdict, data + at, sizeof verdict) != 0) return 1;
        at += 320 + (length + 63) / 64 * 64;
    }
    return 0;
}
"""


def files():
    """What test_readers.py puts to both readers, in the order in which it is likely to tell."""
    yield from (data for _, _, data in make_invalid.cases())
    yield from (data for _, _, data in make_odd.invalid())
    yield from (data for _, data in make_odd.valid())
    goldens = []
    for name in sorted(os.listdir(make_invalid.VALID)):
        with open(os.path.join(make_invalid.VALID, name), "rb") as file:
            goldens.append(file.read())
    yield from goldens
    for data in goldens:
        table_end = 128 + 40 * struct.unpack_from("<I", data, 32)[0]
        yield from (d for _, d in test_readers.damaged(data, range(table_end), test_readers.mend))
        if len(data) < 8192:
            yield from (d for _, d in test_readers.damaged(data, test_readers.section_bytes(data), test_readers.mend))
            yield from (d for _, d in test_readers.damaged(data, range(table_end)))
    shortest = min(goldens, key=len)
    yield from (d for _, d in test_readers.prefixes(shortest))


def record(verdict, data):
    return verdict + struct.pack("<I", len(data)) + bytes(60) + data + bytes(-len(data) % 64)


def build(folder, compiler):
    """Program and the conditions by number, from 1 on."""
    names, sources = [], []
    for name in CHECKERS:
        with open(os.path.join(SOURCE, name), encoding="utf-8") as file:
            text = file.read()
        changed, spans = mutated(text, len(names) + 1)
        lines = [0] + [m.end() for m in re.finditer("\n", text)]
        for start, end, value in spans:
            line = sum(1 for begin in lines if begin <= start)
            names.append((name, line, " ".join(text[start:end].split()), value))
        path = os.path.join(folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(HEADER + f'#line 1 "{name}"\n' + changed)
        sources.append(path)
    main = os.path.join(folder, "main.c")
    with open(main, "w", encoding="utf-8") as file:
        file.write(PROGRAM)
    program = os.path.join(folder, "mutants")
    subprocess.run([compiler, "-std=gnu11", "-O1", "-w", "-I", SOURCE, "-I", os.path.join(ROOT, "runtime", "include"), "-I",
                    os.path.join(ROOT, "formats", "include"), "-o", program, main, *sources, os.path.join(SOURCE, "crc32.c"),
                    os.path.join(SOURCE, "result.c"), "-lm"], check=True)
    return program, names


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--compiler", default="cc")
    parser.add_argument("--every", type=int, default=1, help="try only each so many-th mutant")
    parser.add_argument("--list", action="store_true", help="name the mutants, and stop")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        program, names = build(folder, options.compiler)
        if options.list:
            for number, name in enumerate(names, 1):
                print(number, *name)
            return 0
        path, verdicts = os.path.join(folder, "records"), os.path.join(folder, "verdicts")
        made = list(files())
        with open(path, "wb") as file:
            file.writelines(record(bytes(256), data) for data in made)
        subprocess.run([program, path, "0", verdicts], check=True)
        with open(verdicts, "rb") as file:
            found = [file.read(256) for _ in made]
        with open(path, "wb") as file:
            file.writelines(record(verdict, data) for verdict, data in zip(found, made))
        subprocess.run([program, path, "0"], check=True)
        survived, tried = [], 0
        for number in range(1, len(names) + 1, options.every):
            try:
                status = subprocess.run([program, path, str(number)], timeout=20, stderr=subprocess.DEVNULL).returncode
            except subprocess.TimeoutExpired:
                status = -1
            tried += 1
            if status == 0:
                survived.append(names[number - 1])
    print(f"{tried} of {len(names)} mutants on {len(made)} files")
    same = [m for m in survived if f"{m[0]}:{m[2]}:{m[3]}" in SAME]
    left = [m for m in survived if m not in same]
    print(f"{tried - len(survived)} found, {len(same)} the same program, {len(left)} survived")
    for name, line, condition, value in left:
        print(f"{name}:{line}: {condition} -> {value}")
    return 1 if left else 0


if __name__ == "__main__":
    sys.exit(main())
