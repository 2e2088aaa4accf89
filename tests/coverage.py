#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Which lines and branches of each room the tests reach, by clang's source-based counts.

    cmake --preset coverage && cmake --build --preset coverage      clang-14, libclang-rt-14-dev, llvm-14
    tests/coverage.py                    the whole of ctest, then a table; some tests: -R REGEX or -L LABEL
    tests/coverage.py --table            the table again
    tests/coverage.py --build FOLDER     another folder: the runtime alone is a matter of minutes (-DVOXSHELL_TOOLS=OFF)
    tests/coverage.py --missing runtime  lines with a branch that is not taken both ways, of files whose path begins so

A branch is a way out of a condition as it is written (true and false of each operand of &&, ||, ?: and if); what the
compiler adds for exceptions does not count, nor does a condition that is a constant. A template counts once, whatever it is made for.

Tests that cannot pass where counting is compiled in are left out (UNFIT). Any other that fails is a finding: the table comes all the same, and
the exit code is 1. Branches that this machine has no way to take (OUT_OF_REACH) are counted as missing, and beside that as if they were not there.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]

UNFIT = {
    "tick_size": "the counters are code and constants of the tick",
    "effect_cost_.*": "counts instructions, the counters' among them",
    "test_instructions": "counts the instructions of code that has counters in it here",
    "public_symbols": "the counters' symbols are exported",
}
OUT_OF_REACH = {
    "runtime/src/contact_setup.c": ("__builtin_cpu_supports(", "a machine has one processor"),
    "runtime/src/asset_map.c": ("status.st_size", "no file is larger than 64 bits say (tests/runtime/i686.sh has words of 32)"),
}


def tool(name):
    for found in (name + "-14", name):
        if subprocess.run(["which", found], stdout=subprocess.DEVNULL, check=False).returncode == 0:
            return found
    sys.exit(f"coverage.py: error: no {name} here (Debian: llvm-14)")


def run_tests(build, arguments):
    profiles = build / "profiles"
    profiles.mkdir(exist_ok=True)
    for old in profiles.glob("*.prof*"):
        old.unlink()
    # A pool of two files a program, into which each run adds its counts.
    environment = os.environ | {"LLVM_PROFILE_FILE": str(profiles / "%2m.profraw")}
    # Instrumented code takes a few times as long; what a machine is slow at is no finding here.
    print("left out:", *(f"{names} ({why})" for names, why in UNFIT.items()), sep="\n    ")
    tests = subprocess.run(["ctest", "--test-dir", str(build), "--timeout", "3600", "-E", f"^({'|'.join(UNFIT)})$", *arguments], env=environment, check=False)
    subprocess.run([tool("llvm-profdata"), "merge", "-sparse", "--failure-mode=all", "-o", str(profiles / "all.profdata"), *map(str, profiles.glob("*.profraw"))],
                   check=True)
    return tests.returncode


def counts(build):
    programs = [p for p in sorted((build / "bin").iterdir()) if p.is_file() and os.access(p, os.X_OK)]
    objects = [str(programs[0])] + [word for p in programs[1:] for word in ("-object", str(p))]
    told = subprocess.run([tool("llvm-cov"), "export", "-skip-expansions", "-instr-profile", str(build / "profiles/all.profdata"), *objects],
                          stdout=subprocess.PIPE, check=True)
    files = [(os.path.relpath(file["filename"], ROOT), file) for file in json.loads(told.stdout)["data"][0]["files"]]
    return [(path, file) for path, file in files if path.startswith(("runtime/", "tools/"))]


def branches_of(file):
    """{place: [taken, not taken]}, templates' copies added up."""
    places = {}
    for line, column, line_end, column_end, yes, no, *_rest in file["branches"]:
        taken = places.setdefault((line, column, line_end, column_end), [0, 0])
        taken[0] += yes
        taken[1] += no
    return places


def room_of(path):
    parts = path.split("/")
    if parts[0] == "tools":
        return "/".join(parts[:2])
    return "runtime/devices" if path.startswith("runtime/src/devices/") else parts[0]


def text_of(path, place):
    line, column, line_end, column_end = place
    return (ROOT / path).read_text(encoding="utf-8").splitlines()[line - 1][column - 1:column_end - 1 if line_end == line else None].strip()


def out_of_reach(path, places):
    """Ways out of conditions that nobody here can take."""
    text, _why = OUT_OF_REACH.get(path, (None, None))
    return sum((yes == 0) + (no == 0) for place, (yes, no) in places.items() if text and text in text_of(path, place))


def table(files):
    rooms = {}
    for path, file in files:
        lines, places = file["summary"]["lines"], branches_of(file)
        for room in {room_of(path), path.split("/")[0]}:
            row = rooms.setdefault(room, [0, 0, 0, 0, 0])
            row[0] += lines["covered"]
            row[1] += lines["count"]
            row[2] += sum((yes > 0) + (no > 0) for yes, no in places.values())
            row[3] += 2 * len(places)
            row[4] += out_of_reach(path, places)
    print(f"{'':20}{'lines':>16}{'branches':>20}{'without those out of reach':>32}")
    for room in sorted(rooms):
        a, b, c, d, e = rooms[room]
        print(f"{room:20}{100 * a / max(b, 1):6.1f} % of {b:<7}{100 * c / max(d, 1):6.1f} % of {d:<7}{100 * c / max(d - e, 1):18.1f} % of {d - e}")
    for path, (text, why) in OUT_OF_REACH.items():
        print(f"out of reach in {path}: {text}...: {why}")


def missing(files, prefix):
    for path, file in files:
        if not path.startswith(prefix):
            continue
        for place, (yes, no) in sorted(branches_of(file).items()):
            if yes and no:
                continue
            never = "never" if not yes and not no else "never false" if yes else "never true"
            print(f"{path}:{place[0]}: {never}: {text_of(path, place)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/coverage")
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--missing", metavar="PATH")
    options, rest = parser.parse_known_args()
    failed = run_tests(options.build.resolve(), rest) if not options.table and not options.missing else 0
    files = counts(options.build.resolve())
    if options.missing:
        missing(files, options.missing)
    else:
        table(files)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
