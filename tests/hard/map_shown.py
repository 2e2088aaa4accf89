# SPDX-License-Identifier: MIT
"""The map of the hard cases in map.md, map.csv, and its totals in the README are what hard_suite prints: map_shown.py HARD_SUITE. Numbers
within a percent, those that are rounding errors (below 1e-6) at most so; what is beyond a bound, and what is refused, to the sign."""
import csv
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


def cells(path):
    with open(path, encoding='utf-8') as file:
        return [list(row.values()) for row in csv.DictReader(file)]


def totals(found):
    """Of the README's little table: law and field -> how many hold."""
    lines = [[cell.strip(' *') for cell in line.strip('|').split('|')] for line in (SOURCE.parent.parent / 'README.md').read_text(encoding='utf-8').splitlines() if line.startswith('| ')]
    laws = next(line for line in lines if line[0] == 'field')
    shown = {f'{law}/{line[0]}': line[n] for line in lines if line[0] in ('surface', 'layers', 'distance') for n, law in enumerate(laws) if n and line[n]}
    return shown, dict(zip([pair.strip() for pair in found[0][2:]], [cell.strip('*') for cell in found[-1][2:]]))


def main():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.argv[1], '--markdown', f'{folder}/map.md', '--csv', f'{folder}/map.csv'], check=True, stdout=subprocess.DEVNULL)
        found, rows = table(pathlib.Path(folder, 'map.md').read_text(encoding='utf-8')), cells(f'{folder}/map.csv')
    wrong = 0
    for name, shown, wanted in (('map.md', table((SOURCE / 'map.md').read_text(encoding='utf-8')), found), ('map.csv', cells(SOURCE / 'map.csv'), rows)):
        if len(shown) != len(wanted) or len(wanted) < 20:
            sys.exit(f'{name}: {len(shown)} rows, hard_suite has {len(wanted)}')
        for row, right in zip(shown, wanted):
            for cell, value in zip(row, right):
                if not same(cell, value):
                    print(f'{name}: {row[0]}: {cell}, now {value}')
                    wrong += 1
    shown, wanted = totals(found)
    if shown != wanted:
        print(f'README.md: {shown}, now {wanted}')
        wrong += 1
    sys.exit(wrong > 0)


main()
