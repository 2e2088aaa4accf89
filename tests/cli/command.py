# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the command line in a folder of its own and checks what it said and how it ended."""
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

BIN = os.environ.get('VOXSHELL', 'voxshell')
SOURCE = pathlib.Path(os.environ.get('VOXSHELL_SOURCE', pathlib.Path(__file__).parents[2]))
SKIPPED = 77


def built_with(option):
    """Whether the build has an option of CMakeLists.txt that says more than OFF."""
    cache = pathlib.Path(os.environ.get('VOXSHELL_BUILD', 'none'), 'CMakeCache.txt')
    return cache.exists() and re.search(rf'^{option}:\w+=(?!OFF$).+$', cache.read_text(encoding='utf-8'), re.M) is not None


def sanitized():
    """Sanitizers multiply memory and time: what is measured then says nothing about the program."""
    return built_with('VOXSHELL_SANITIZE')


def counting():
    """The coverage's counters are instructions, too."""
    return built_with('VOXSHELL_COVERAGE')


def shim(source, folder):
    """A C file beside the tests as a library for LD_PRELOAD, in the folder. Without a compiler or with sanitizers, which must be the first library, the test is
    skipped."""
    compiler = shutil.which('cc') or shutil.which('gcc')
    if not compiler or sanitized():
        raise unittest.SkipTest('no C compiler, or sanitizers')
    library = os.path.join(folder, pathlib.Path(source).stem + '.so')
    subprocess.run([compiler, '-O1', '-shared', '-fPIC', '-o', library, pathlib.Path(__file__).with_name(source), '-ldl'], check=True)
    return library


class CommandTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix='voxshell-'))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, *names):
        return str(self.folder.joinpath(*names))

    def run_voxshell(self, *arguments, code=0, out=None, err=None, env=None, timeout=120):
        """Exit code, stdout and stderr (patterns; '' means nothing at all) are all checked."""
        done = subprocess.run([BIN, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True,
                              timeout=timeout, env={**os.environ, **(env or {})}, stdin=subprocess.DEVNULL)
        said = f'\nvoxshell {" ".join(map(str, arguments))}\nexit {done.returncode}\nstdout: {done.stdout}\nstderr: {done.stderr}'
        self.assertEqual(done.returncode, code, said)
        for name, text, pattern in (('stdout', done.stdout, out), ('stderr', done.stderr, err)):
            if pattern == '':
                self.assertEqual(text, '', said)
            elif pattern is not None:
                self.assertTrue(re.search(pattern, text, re.S), f'{name} does not match {pattern!r}{said}')
        return done

    def refused(self, code, pattern, *arguments, verb='convert', **more):
        """One line of error (usage adds where to look), nothing on stdout, nothing left behind."""
        before = self.listing()
        done = self.run_voxshell(verb, *arguments, code=code, out='', **more)
        lines = done.stderr.splitlines()
        self.assertRegex(lines[0], rf'^voxshell {verb}: error: ')
        self.assertRegex(lines[0], pattern)
        self.assertEqual(lines[1:], [f'see voxshell {verb} --help'] if code == 1 else [])
        self.assertEqual(self.listing(), before)
        return done

    def listing(self, folder=None):
        root = pathlib.Path(folder) if folder else self.folder
        return sorted(str(p.relative_to(root)) for p in root.rglob('*'))

    def digests(self, folder):
        root = pathlib.Path(folder)
        return {str(p.relative_to(root)): hashlib.sha256(p.read_bytes()).hexdigest()
                for p in sorted(root.rglob('*')) if p.is_file()}

    def load(self, *names):
        with open(self.path(*names), encoding='utf-8') as file:
            return json.load(file)


def main():
    """Like unittest.main(), but a run in which every test was skipped ends with 77."""
    result = unittest.main(exit=False).result
    if not result.wasSuccessful():
        sys.exit(1)
    one_by_one = sum(isinstance(test, unittest.TestCase) for test, _ in result.skipped)  # the others are whole classes, of which no test was run
    sys.exit(SKIPPED if result.skipped and one_by_one == result.testsRun else 0)
