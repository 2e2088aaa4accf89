# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the commands of the READMEs, the guide and the samples as they are printed: docs_commands.py [DOCUMENT...].

Each block that begins with ```sh runs, line by line, in a copy of the built test bed, with the built command in the PATH: those of the README where the repository is, the others in
build/release/samples. A command must end with 0, or with N where its comment says "exit status N". A ```python block runs as a whole, in the folder where the commands before it
ended, by the Python of lab/, the environment that they made. What is not run here stands under a comment in the document, with the reason:

    <!-- not run: needs a device -->
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import command

sys.path.append(str(command.SOURCE / 'tests/runtime/python'))
import python_package

BUILD = pathlib.Path(os.environ.get('VOXSHELL_BUILD', command.SOURCE / 'build/release'))
PYTHON = 'runtime/python/README.md'
DOCUMENTS = ['README.md', PYTHON, *sorted(str(p.relative_to(command.SOURCE)) for p in command.SOURCE.glob('samples/**/README.md'))]
FENCE = re.compile(r'(?:^<!-- not run: (?P<reason>[^\n]*) -->\n)?^```(?P<kind>\w*)\n(?P<text>.*?)^```$', re.M | re.S)
PROMPTS = re.compile(r'^(    |\t)(voxshell|cmake|ctest|sh|python3|\.\./) ', re.M)


def commands(text):
    """(command, exit status) of a block: a line each, a comment after it apart."""
    for line in text.splitlines():
        status = re.search(r'#.*exit status (\d+)', line)
        if line.split('#')[0].strip():
            yield line, int(status[1]) if status else 0


class Copy:
    """The repository as a reader has it after the build: folders of the source, and the test bed to write in."""

    def __init__(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix='voxshell-docs-'))
        for name in os.listdir(command.SOURCE):
            if name not in ('build', '.git'):
                os.symlink(command.SOURCE / name, self.root / name)
        release = self.root / 'build/release'
        shutil.copytree(BUILD / 'samples', release / 'samples', ignore=shutil.ignore_patterns('CMakeFiles', '*.cmake'))
        os.symlink(BUILD / 'bin', release / 'bin')
        self.path = f'{release / "bin"}:{os.environ["PATH"]}'

    def take_python(self, interpreter):
        """What the reader's python3 is: one that has what the document asks for."""
        os.mkdir(self.root / '.python')
        (self.root / '.python/python3').write_text(f'#!/bin/sh\nexec {interpreter} "$@"\n')
        (self.root / '.python/python3').chmod(0o755)
        self.path = f'{self.root / ".python"}:{self.path}'

    def run(self, lines, folder):
        """One shell for a block, as a reader has one window; the folder that it ends in."""
        script = 'PATH=$DOCS_PATH\n'
        for line, status in lines:
            script += f'{line}\n[ $? -eq {status} ] || {{ echo "docs: line failed: "{quoted(line)} >&2; exit 99; }}\n'
        done = subprocess.run(['sh', '-c', script + 'pwd >"$DOCS_END"'], cwd=folder, capture_output=True, text=True, timeout=280, check=False,
                              env={**os.environ, 'DOCS_PATH': self.path, 'DOCS_END': str(self.root / '.end'), 'DOCS_ROOT': str(self.root), 'PYTHONPATH': ''}, stdin=subprocess.DEVNULL)
        return done, pathlib.Path((self.root / '.end').read_text().strip()) if done.returncode == 0 else folder


def quoted(text):
    return "'" + text.replace("'", "'\\''") + "'"


class Documents(unittest.TestCase):
    def test_extraction(self):
        """The rules above, on a text that has each case."""
        text = 'a\n```sh\nvoxshell one   # exit status 4\n\n# a comment\nvoxshell two\n```\n<!-- not run: root -->\n```sh\nrm\n```\n```c\nint x;\n```\n'
        found = [(m['reason'], m['kind'], list(commands(m['text']))) for m in FENCE.finditer(text)]
        self.assertEqual(found[0], (None, 'sh', [('voxshell one   # exit status 4', 4), ('voxshell two', 0)]))
        self.assertEqual([f[:2] for f in found[1:]], [('root', 'sh'), (None, 'c')])

    def test_commands(self):
        total = 0
        for name in [a for a in sys.argv[1:] if a.endswith('.md')] or DOCUMENTS:
            text = (command.SOURCE / name).read_text(encoding='utf-8')
            self.assertNotRegex(text, PROMPTS, f'{name}: a command outside a ```sh block would not be run')
            copy = Copy()
            self.addCleanup(shutil.rmtree, copy.root, ignore_errors=True)
            folder, begin, count = copy.root / ('' if name in ('README.md', PYTHON) else 'build/release/samples'), time.monotonic(), 0
            if name == PYTHON:
                interpreter = python_package.suitable()
                if not interpreter:
                    continue
                copy.take_python(interpreter)
            for block in FENCE.finditer(text):
                if block['kind'] not in ('sh', 'python'):
                    continue
                lines = list(commands(block['text']))
                if block['reason']:
                    print(f'{name}: not run ({block["reason"]}): {lines[0][0].split("#")[0].strip()}')
                    continue
                if block['kind'] == 'python':
                    (copy.root / '.block.py').write_text(block['text'], encoding='utf-8')
                    lines = [('"$DOCS_ROOT"/lab/bin/python "$DOCS_ROOT"/.block.py', 0)]
                done, folder = copy.run(lines, folder)
                self.assertEqual(done.returncode, 0, f'{name}:\n{block["text"]}\n{done.stdout}\n{done.stderr}')
                count += len(lines)
            if count:
                print(f'{name}: {count} commands in {time.monotonic() - begin:.1f} s')
            total += count
        self.assertGreater(total, 0)


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1])
