#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`voxshell inspect --format json` and the Python reader say the same of every golden, and both refuse a broken
file by the same rule."""
import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
sys.path += [os.path.join(ROOT, "formats", "reference"), os.path.join(ROOT, "tests", "golden")]

import make_invalid  # noqa: E402
import read_asset  # noqa: E402

VOXSHELL = os.environ.get("VOXSHELL", "")


def inspect(path):
    done = subprocess.run([VOXSHELL, "inspect", "--format", "json", path], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


def check_goldens():
    for name in sorted(os.listdir(make_invalid.VALID)):
        path = os.path.join(make_invalid.VALID, name)
        status, out, err = inspect(path)
        assert status == 0 and not err, f"{name}: {status} {err}"
        said, summary = json.loads(out), read_asset.open_asset(path).summary()
        assert said == summary, f"{name}: inspect says {said}, the Python reader {summary}"


def check_refusals():
    with tempfile.TemporaryDirectory() as folder:
        for name, rule, data in make_invalid.cases():
            path = os.path.join(folder, name)
            with open(path, "wb") as file:
                file.write(data)
            status, out, err = inspect(path)
            assert status == (5 if rule in ("C103", "C105") else 3), f"{name}: exit status {status}"
            rule_text = "" if rule in ("C101", "C102") else f"rule {rule} section "  # no magic: inspect cannot tell the kind
            assert not out and err.startswith(f"voxshell inspect: error: {path}: {rule_text}"), f"{name}: {err}"
            assert err.count("\n") == 1, f"{name}: {err}"


if __name__ == "__main__":
    if not os.access(VOXSHELL, os.X_OK):
        print("skipped: $VOXSHELL is no program")
        sys.exit(77)
    check_goldens()
    check_refusals()
