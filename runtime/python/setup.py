# SPDX-License-Identifier: MIT
"""Makes the wheel, which carries the runtime's shared library: compiled here with CMake, or $VOXSHELL_LIBRARY if that is set."""
import atexit
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

if sys.version_info < (3, 9):
    sys.exit("voxshell: needs Python 3.9 or newer, and this is %d.%d" % sys.version_info[:2])

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:
    from wheel.bdist_wheel import bdist_wheel

ROOT = pathlib.Path(__file__).resolve().parents[2]
VERSION = re.search(r"project\(voxshell VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
SCRATCH = pathlib.Path(tempfile.mkdtemp(prefix="voxshell-python-"))  # the source folder stays as it is
atexit.register(shutil.rmtree, SCRATCH, ignore_errors=True)


def libraries():
    """Each name in the package to a file: the runtime's, and that of the devices where there is one."""
    if os.environ.get("VOXSHELL_LIBRARY"):
        given = pathlib.Path(os.environ["VOXSHELL_LIBRARY"])
        found = {"libvoxshell.so": given, "libvoxshell-devices.so": given.with_name("libvoxshell-devices.so")}
        return {name: file for name, file in found.items() if file.exists() or file == given}
    build = SCRATCH / "runtime"
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    options = ["-DCMAKE_SKIP_RPATH=ON", *[f"-DVOXSHELL_{part}=OFF" for part in ("TOOLS", "TESTS", "SAMPLES", "USB")]]
    subprocess.run(["cmake", "-S", ROOT, "-B", build, *generator, *options], check=True)
    subprocess.run(["cmake", "--build", build, "--target", "voxshell_runtime_shared", "voxshell_devices_shared"], check=True)
    return {f"{name}.so": next(file for file in build.rglob(f"{name}.so*") if not file.is_symlink()) for name in ("libvoxshell", "libvoxshell-devices")}


class WithLibraries(build_py):
    def run(self):
        super().run()
        for name, file in libraries().items():
            shutil.copy(file, pathlib.Path(self.build_lib, "voxshell", name))


class OfAMachine(Distribution):
    def has_ext_modules(self):
        return True


class Wheel(bdist_wheel):
    """For any Python 3 on a machine that the library is for."""

    def get_tag(self):
        return "py3", "none", super().get_tag()[2]


for folder in ("build", "egg"):
    (SCRATCH / folder).mkdir()
setup(
    name="voxshell",
    version=VERSION,
    description="Assets as numpy arrays, and the runtime that feels them",
    long_description=pathlib.Path(__file__).with_name("README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    license="MIT",
    packages=["voxshell"],
    python_requires=">=3.9",
    install_requires=["numpy"],
    distclass=OfAMachine,
    cmdclass={"build_py": WithLibraries, "bdist_wheel": Wheel},
    options={"build": {"build_base": str(SCRATCH / "build")}, "egg_info": {"egg_base": str(SCRATCH / "egg")}},
)
