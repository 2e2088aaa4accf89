# SPDX-License-Identifier: GPL-3.0-or-later
"""Every build folder and machine makes the same assets of the test bed: golden_assets.py GOLDEN MODELS [--write]

GOLDEN is a `sha256sum` list of the files that `convert` makes of the models in MODELS (samples/models/generate.py:
the same bytes everywhere). With --write it is made anew; say why in CHANGELOG.md.
"""
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile

RUNS = [  # output folder, models, options
    ('glb', ['cup.glb', 'sphere.glb', 'pair.glb'], ['--voxel', '2mm']),
    ('stl', ['cup.stl', 'sphere.stl'], ['--voxel', '0.5mm', '--unit', 'mm']),
    ('naive', ['sphere.glb'], ['--voxel', '1mm', '--shell', 'naive']),
    ('scene', ['cup_press.scene.json'], []),
    ('channels', ['cup.glb'], ['--voxel', '1mm', '--channels', 'layers:3,distance:3']),
]


def make(voxshell, models):
    with tempfile.TemporaryDirectory(prefix='voxshell-') as folder:
        for name, inputs, options in RUNS:
            subprocess.run([voxshell, 'convert', *(models / i for i in inputs), '-o', f'{folder}/{name}', '-q', *options],
                           check=True, stdout=subprocess.DEVNULL)
        made = pathlib.Path(folder)
        return ''.join(f'{hashlib.sha256(p.read_bytes()).hexdigest()}  {p.relative_to(made)}\n'
                       for p in sorted(made.rglob('*')) if p.is_file())


def main():
    golden, models = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    got = make(os.environ.get('VOXSHELL', 'voxshell'), models)
    if '--write' in sys.argv:
        golden.write_text(got, encoding='utf-8')
        return 0
    expected = golden.read_text(encoding='utf-8')
    for line in sorted(set(got.splitlines()) ^ set(expected.splitlines()), key=lambda text: text[66:]):
        print('expected' if line in expected.splitlines() else 'got     ', line)
    return int(got != expected)


if __name__ == '__main__':
    sys.exit(main())
