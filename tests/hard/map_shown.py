# SPDX-License-Identifier: MIT
"""The map of the hard cases in map.md and in the README is what hard_suite prints: map_shown.py HARD_SUITE. Numbers within a percent, those
that are rounding errors (below 1e-6) at most so; what is beyond a bound, and what is refused, to the sign."""
import pathlib
import re
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parent
ROUNDING = 1e-6


def table(text):
    return [[cell.strip() for cell in line.strip('|').split('|')] for line in text.splitlines() if line.startswith('| ') and line.count('|') == 13]


def same(shown, found):
    style = [re.sub('[^*–]', '', cell) for cell in (shown, found)]
    if style[0] != style[1]:
        return False
    try:
        a, b = (float(cell.strip('*')) for cell in (shown, found))
    except ValueError:
        return shown == found
    return abs(a - b) <= 0.01 * abs(b) or max(abs(a), abs(b)) < ROUNDING


def main():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.argv[1], '--markdown', f'{folder}/map.md'], check=True, stdout=subprocess.DEVNULL)
        found = table(pathlib.Path(folder, 'map.md').read_text(encoding='utf-8'))
    wrong = 0
    for path in (SOURCE / 'map.md', SOURCE.parent.parent / 'README.md'):
        shown = table(path.read_text(encoding='utf-8'))
        if len(shown) != len(found) or len(found) < 20:
            sys.exit(f'{path}: {len(shown)} rows, hard_suite has {len(found)}')
        for row, wanted in zip(shown, found):
            for cell, value in zip(row, wanted):
                if not same(cell, value):
                    print(f'{path}: {row[0]}: {cell}, now {value}')
                    wrong += 1
    sys.exit(wrong > 0)


main()
