# SPDX-License-Identifier: GPL-3.0-or-later
"""The man pages and the completion say what --help says: each verb, each option, each value."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

BIN = os.environ['VOXSHELL']


def run(*command, **more):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False, **more)
    if done.returncode:
        raise AssertionError(f'{" ".join(map(str, command))}: exit {done.returncode}\n{done.stdout}{done.stderr}')
    return done.stdout + done.stderr


def options(help_text):
    """All names in the left column: '-o, --output DIR'."""
    part = help_text.split('\noptions\n')[1].split('\n\n')[0]
    return {name for line in part.splitlines() if re.match(r'  -', line) for name in re.findall(r'(?<![\w-])--?[a-z][\w-]*', line[:24] if len(line) > 24 and line[23] == ' ' else line)}


class Manual(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix='voxshell-'))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        run(BIN, '--write-manual', cls.folder)
        cls.help = {'': run(BIN, '--help')}
        for verb in re.findall(r'^  (\w+) ', cls.help[''].split('verbs\n')[1].split('options\n')[0], re.M):
            cls.help[verb] = run(BIN, verb, '--help')

    def page(self, verb):
        return self.folder / 'man1' / (f'voxshell-{verb}.1' if verb else 'voxshell.1')

    def test_a_page_for_each_verb_with_each_option(self):
        self.assertGreater(len(self.help), 10)
        self.assertEqual(len(list((self.folder / 'man1').iterdir())), len(self.help))
        for verb, text in self.help.items():
            self.assertGreaterEqual(len(options(text)), 2)
            page = self.page(verb).read_text(encoding='utf-8').replace('\\-', '-')
            for name in options(text):
                self.assertIn(f'\\fB{name}\\fR', page, f'{verb} {name}')
            for title in ('NAME', 'SYNOPSIS', 'EXAMPLES', 'OPTIONS', 'EXIT STATUS', 'SEE ALSO'):
                self.assertIn(f'.SH {title}\n', page)
            said = ' '.join(re.sub(r'\\f[BRI]|^\.\w+|\\&', '', page, flags=re.M).replace('\\e', '\\').split())
            for line in text.split('\noptions\n')[1].split('\n\n')[0].splitlines():
                if line[23:24] == ' ' and line[24:].strip():
                    self.assertIn(' '.join(line[24:].split()), said, verb)

    @unittest.skipUnless(shutil.which('groff'), 'no groff')
    def test_the_pages_are_right_for_man(self):
        for verb in self.help:
            done = subprocess.run(['groff', '-man', '-ww', '-Tutf8', self.page(verb)], capture_output=True, text=True, check=True)
            self.assertEqual(done.stderr, '', verb)
            self.assertIn('voxshell', done.stdout)

    def complete(self, *words):
        script = f'source {self.folder}/completions/voxshell; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _voxshell; printf "%s\\n" "${{COMPREPLY[@]}}"'
        return set(run('bash', '-c', script, 'bash', *words).split())

    @unittest.skipUnless(shutil.which('bash'), 'no bash')
    def test_completion(self):
        verbs = set(self.help) - {''}
        self.assertEqual(self.complete('voxshell', ''), verbs | {'--help', '--version'})
        self.assertEqual(self.complete('voxshell', 'conv'), {'convert'})
        self.assertEqual(self.complete('voxshell', 'convert', '--unit', ''), {'mm', 'cm', 'm', 'in'})
        self.assertEqual(self.complete('voxshell', 'convert', 'a.stl', '--progress', 'a'), {'auto', 'always'})
        self.assertEqual(self.complete('voxshell', 'convert', '-o', ''), set())  # files: the shell's own
        self.assertLessEqual({'list', 'doctor', 'test'}, self.complete('voxshell', 'device', ''))
        for verb in verbs:
            self.assertLessEqual(options(self.help[verb]), self.complete('voxshell', verb, 'x', '-'), verb)


if __name__ == '__main__':
    unittest.main()
