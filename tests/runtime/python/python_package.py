# SPDX-License-Identifier: MIT
"""runtime/python as a laboratory has it: the wheel made without a network, installed into a new environment, and its tests run
there: python_package.py C_COMPILER."""
import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
PACKAGE = HERE.parents[2] / "runtime" / "python"
NEEDS = "import setuptools, ensurepip, numpy, pip, venv\n" \
        "try: from setuptools.command.bdist_wheel import bdist_wheel\n" \
        "except ImportError: import wheel"
SKIPPED = 77


def run(*command, **more):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **more)
    assert done.returncode == 0, f"{' '.join(map(str, command))}: exit status {done.returncode}\n{done.stdout}"
    return done.stdout


def suitable():
    """An interpreter that can do it: this one, or the system's; else None."""
    for interpreter in dict.fromkeys((sys.executable, "/usr/bin/python3")):
        if os.path.exists(interpreter) and subprocess.run([interpreter, "-c", NEEDS], stderr=subprocess.DEVNULL, check=False).returncode == 0:
            return interpreter
    print("skipped: no Python 3 with numpy, pip, setuptools, wheel and venv (Debian: python3-numpy python3-pip python3-setuptools "
          "python3-wheel python3-venv)")
    return None


def main(compiler):
    python = suitable()
    if not python:
        sys.exit(SKIPPED)
    before = sorted(PACKAGE.rglob("*"))
    with tempfile.TemporaryDirectory(prefix="voxshell-python-") as folder:
        wheels, room = pathlib.Path(folder, "wheels"), pathlib.Path(folder, "room")
        run(python, "-m", "pip", "wheel", PACKAGE, "--no-build-isolation", "--no-index", "--no-deps", "-w", wheels)
        (wheel,) = wheels.iterdir()
        assert wheel.name.endswith(".whl") and "-py3-none-linux_" in wheel.name, wheel.name
        assert sorted(PACKAGE.rglob("*")) == before, "making a wheel leaves something in the source folder"
        run(python, "-m", "venv", "--system-site-packages", room)
        run(room / "bin" / "pip", "install", "--no-index", wheel)
        print(f"{wheel.name}: {wheel.stat().st_size} bytes, {python}")
        env = {**os.environ, "VXS_CC": compiler, "PYTHONPATH": ""}
        for name in ("test_layout_of_structs", "test_assets", "test_runtime", "test_servo_thread"):
            done = subprocess.run([room / "bin" / "python", HERE / f"{name}.py"], cwd=folder, env=env, check=False)
            assert done.returncode == 0, f"{name}: exit status {done.returncode}"


if __name__ == "__main__":
    main(*sys.argv[1:])
