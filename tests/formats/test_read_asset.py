#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What the Python reader says of the goldens, and how it ends, against numbers known by construction."""
import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
READER = os.path.join(ROOT, "formats", "reference", "read_asset.py")
VALID = os.path.join(ROOT, "tests", "golden", "valid")
sys.path += [os.path.dirname(READER), os.path.join(ROOT, "tests", "cli")]

import read_asset  # noqa: E402
import schema  # noqa: E402


def golden(name):
    return os.path.join(VALID, name)


def run(*arguments):
    done = subprocess.run([sys.executable, READER, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


def check_cells():
    map_ = read_asset.open_asset(golden("one_cell.voxmap"))
    assert list(map_.cells()) == [(0, 0, 0, 1)]
    assert map_.state(0, 0, 0) == 1 and map_.state(0, 0, 1) == 0 and map_.state(-1, 0, 0) == 0 and map_.state(64, 0, 0) == 0

    map_ = read_asset.open_asset(golden("uniform.voxmap"))
    cells = {c[:3]: c[3] for c in map_.cells()}
    assert len(cells) == 64**3 + 512 + 4 + 8
    expected = {(-64, 0, 136 + k): 1 for k in range(8)}
    expected.update({(-63, 0, 136 + k): 2 for k in range(4)})
    expected.update({(i, j, k): 2 for i in range(-64, 0) for j in range(64) for k in range(64, 128)})
    expected.update({(i, j, k): 2 for i in range(-64, -56) for j in range(8) for k in range(128, 136)})
    assert cells == expected
    for at in [(-64, 0, 136), (-63, 0, 139), (-63, 0, 140), (-1, 63, 127), (-1, 63, 128), (-57, 7, 135), (-56, 7, 135), (0, 0, 64)]:
        assert map_.state(*at) == expected.get(at, 0), at


def check_points():
    shell = read_asset.open_asset(golden("one_point.pointshell"))
    (point,) = shell.points()
    assert point[:6] == (0.5, 0.25, -2.0, 0.0, 0.0, -1.0) and abs(point[6] - 1e-6) < 1e-13
    points = list(read_asset.open_asset(golden("two_clusters.pointshell")).points())
    assert [p[0] for p in points] == [n / 16 for n in range(70)]
    assert all(p[6] == 0.25 for p in points)
    bare = read_asset.open_asset(golden("no_area.pointshell"))
    assert list(bare.points()) == [p[:6] for p in points] and not bare.has_areas and bare.area == 17.5


def check_command():
    for name in os.listdir(VALID):
        assert run("--check", golden(name)) == (0, "OK\n", ""), name
    status, out, _ = run(golden("two_clusters.pointshell"))
    summary = json.loads(out)
    assert status == 0
    assert summary["points"] == 70 and summary["clusters"] == 2 and summary["area_m2"] == 17.5
    assert summary["kind"] == "pointshell" and summary["kind_of_shell"] == "naive" and summary["bytes"] == 3072
    assert summary["source_sha256"] == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"
    summary = json.loads(run(golden("uniform.voxmap"))[1])
    assert summary["interior_cells"] == 262660 and summary["surface_cells"] == 8 and summary["channels"] == []
    assert summary["bbox_cells"] == {"min": [-64, 0, 64], "max": [-1, 63, 143]}
    assert json.loads(run(golden("channels.voxmap"))[1])["channels"] == ["layers", "distance"]

    with tempfile.TemporaryDirectory() as folder:
        broken = os.path.join(folder, "broken.voxmap")
        with open(golden("one_cell.voxmap"), "rb") as file:
            data = file.read()
        with open(broken, "wb") as file:
            file.write(data[:-64])
        text = "rule C106 section HEAD offset 16: file_size 2880, but the file has 2816 bytes\n"
        assert run("--check", broken) == (3, text, "")
        assert run(broken) == (3, "", f"read_asset.py: error: {broken}: {text}")
        status, out, err = run("--check", os.path.join(folder, "missing.voxmap"))
        assert status == 2 and not out and "No such file" in err
    assert run()[0] == 1 and run("--wrong", broken)[0] == 1
    status, out, err = run("--help")
    assert status == 0 and "--check" in out and not err


def check_schema():
    with open(os.path.join(ROOT, "formats", "schema", "inspect.schema.json"), encoding="utf-8") as file:
        inspect = json.load(file)
    for name in os.listdir(VALID):
        found = schema.problems(read_asset.open_asset(golden(name)).summary(), inspect)
        assert not found, f"{name}: {found}"


if __name__ == "__main__":
    check_schema()
    check_cells()
    check_points()
    check_command()
