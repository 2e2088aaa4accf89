# SPDX-License-Identifier: MIT
"""Makes the wheel, which carries the runtime's shared library: compiled here with CMake, or $VOXSHELL_LIBRARY if that is set."""
import atexit
import os
import pathlib
import re
import shutil
import subprocess
import tempfile

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


def library():
    if os.environ.get("VOXSHELL_LIBRARY"):
        return pathlib.Path(os.environ["VOXSHELL_LIBRARY"])
    build = SCRATCH / "runtime"
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    options = [f"-DVOXSHELL_{part}=OFF" for part in ("TOOLS", "TESTS", "SAMPLES", "USB")]
    subprocess.run(["cmake", "-S", ROOT, "-B", build, *generator, *options], check=True)
    subprocess.run(["cmake", "--build", build, "--target", "voxshell_runtime_shared"], check=True)
    return next(file for file in build.rglob("libvoxshell.so*") if not file.is_symlink())


class WithLibrary(build_py):
    def run(self):
        super().run()
        shutil.copy(library(), pathlib.Path(self.build_lib, "voxshell", "libvoxshell.so"))


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
    cmdclass={"build_py": WithLibrary, "bdist_wheel": Wheel},
    options={"build": {"build_base": str(SCRATCH / "build")}, "egg_info": {"egg_base": str(SCRATCH / "egg")}},
)
