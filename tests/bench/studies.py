# SPDX-License-Identifier: GPL-3.0-or-later
"""All three studies on all sample scenes, and a front page: seconds of each, by the clock and of the processor.

    python3 tests/bench/studies.py -o DIR [--quick] [--twice] [--build build/release]

--twice: each study again on one thread, and every file but times the same to the last byte. Ends with 1 where a study fails or files
differ. All together are to take 15 minutes on two cores, and one with --quick."""
import argparse
import json
import pathlib
import resource
import subprocess
import sys
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def timed_files(folder):
    """What is not the same on every run, as the study itself says."""
    told = json.loads((folder / 'summary.json').read_text())
    timed = {column['csv'] for table in told['tables'] for column in table['columns'] if 'csv' in column}
    timed |= {figure[kind] for figure in told['figures'] if figure.get('timed') for kind in ('csv', 'svg', 'png') if kind in figure}
    return {'timing.csv'} | timed | ({'summary.json', 'index.html'} if timed else set())


def differing(first, second):
    names = [{path.name for path in folder.iterdir()} for folder in (first, second)]
    kept = (names[0] & names[1]) - timed_files(first) - timed_files(second)
    return sorted((names[0] ^ names[1]) | {name for name in kept if (first / name).read_bytes() != (second / name).read_bytes()}), len(kept)


def run(program, arguments, folder, *more):
    """Wall and processor seconds, or nothing where it failed."""
    command = [program, 'study', *arguments, '-o', folder, '-q', '--force', *more]
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    done = subprocess.run(list(map(str, command)), stdout=subprocess.DEVNULL, check=False)
    wall, after = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return (wall, used) if done.returncode == 0 else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('-o', dest='out', type=pathlib.Path, required=True)
    parser.add_argument('--quick', action='store_true')
    parser.add_argument('--twice', action='store_true')
    parser.add_argument('--build', type=pathlib.Path, default=SOURCE / 'build/release')
    options = parser.parse_args()
    program = options.build / 'bin/voxshell'
    scenes = sorted((options.build / 'samples').glob('*.scene.json'))
    if not program.exists() or not scenes:
        sys.exit(f'{options.build}: no bin/voxshell, or no samples: build both, or say --build')
    quick = ['--quick'] if options.quick else []
    studies = {f'accuracy-{scene.name.removesuffix(".scene.json")}': ['accuracy', scene, *quick] for scene in scenes}
    studies['paper'] = ['paper', *quick]
    studies['stability'] = ['stability', *quick, '--hard-map', SOURCE / 'tests/hard/map.csv']
    walls, useds, bad = 0, 0, False
    for name, arguments in studies.items():
        took = run(program, arguments, options.out / name)
        if took is None:
            print(f'{name:24} failed')
            bad = True
            continue
        walls, useds = walls + took[0], useds + took[1]
        print(f'{name:24} {took[0]:7.1f} s, processor {took[1]:7.1f} s', end='', flush=True)
        if options.twice:
            again = options.out / f'again-{name}'
            if run(program, arguments, again, '-j', '1') is None:
                print('; again: failed', end='')
                bad = True
            else:
                others, same = differing(options.out / name, again)
                print(f'; again: {same} files the same' + (f', OTHERS: {", ".join(others)}' if others else ''), end='')
                bad |= bool(others)
                for path in again.iterdir():
                    path.unlink()
                again.rmdir()
        print(flush=True)
    if not bad:
        subprocess.run([program, 'study', 'index', '-o', options.out, '-q', '--force'], check=True)
    print(f'{"all":24} {walls:7.1f} s, processor {useds:7.1f} s')
    return bad


if __name__ == '__main__':
    sys.exit(main())
