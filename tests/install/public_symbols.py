# SPDX-License-Identifier: MIT
"""What the shared libraries export is what symbols.txt says, and each of it is declared in a header, under a comment that is its manual.
    public_symbols.py LIBRARY... [--write]"""
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
HEADERS = HERE.parents[1] / 'runtime/include/voxshell'
LIST = HERE / 'symbols.txt'


def exported(library):
    said = subprocess.run(['nm', '-D', '--defined-only', library], capture_output=True, text=True, check=True).stdout
    name = pathlib.Path(library).name.split('.so')[0]
    return [f'{name} {line.split()[-1]}' for line in said.splitlines() if not line.split()[-1].startswith(('__asan', '__odr_asan'))]


def manual():
    """Each function to the comment above it: its own, or that of the block of declarations in which it stands. A header may say for
    all of it which thread may call it."""
    out = {}
    for header in sorted(HEADERS.glob('*.h')):
        text = header.read_text(encoding='utf-8')
        head = text.split('*/')[0]
        of_all = re.search(r'Everything here: (Thread:.*)', head)
        for piece in re.split(r'\n\s*\n', text):
            block = ''
            for comment, name in re.findall(r'/\*(.*?)\*/|^VXS_API\b[^;(]*?\**(vxs_\w+)\(', piece, re.M | re.S):
                block = comment or block
                if name:
                    out[name] = block + (of_all[1] if of_all else '')
    return out


def main():
    libraries = [a for a in sys.argv[1:] if a != '--write']
    if not shutil.which('nm'):
        print('public_symbols: skipped: no nm', file=sys.stderr)
        sys.exit(77)
    found = sorted({line for library in libraries for line in exported(library)})
    if '--write' in sys.argv:
        LIST.write_text('\n'.join(found) + '\n', encoding='utf-8')
    known = LIST.read_text(encoding='utf-8').split('\n')[:-1]
    problems = [f'{line}: exported, but not in symbols.txt' for line in found if line not in known]
    problems += [f'{line}: in symbols.txt, but gone: programs that use it no longer load' for line in known if line not in found]
    documented = manual()
    for line in found:
        name = line.split()[1]
        text = documented.get(name)
        if text is None:
            problems.append(f'{name}: declared in no header')
        elif len(text.split()) < 4 or not re.search(r'Thread|rt-safe|set-up', text):
            problems.append(f'{name}: no manual above it that says what it is and which thread may call it: "{" ".join(text.split())[:60]}"')
    problems += [f'{name}: declared as public, but not exported' for name in documented if not any(line.split()[1] == name for line in found)]
    print('\n'.join(problems) or f'{len(found)} symbols, each with its manual')
    sys.exit(1 if problems else 0)


if __name__ == '__main__':
    main()
