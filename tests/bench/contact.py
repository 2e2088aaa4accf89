# SPDX-License-Identifier: GPL-3.0-or-later
"""The contact engine beside its peers, one machine, one thread, one run, taking turns:
    ninja -C build/release bench && python3 tests/bench/contact.py build/release/bin
Prints what it measures and writes results/contact.md, .json and .svg. --only voxshell (or any rival's name) and --motion,
--size, --voxel narrow it down; then, and with --dry, nothing is written. A peer that is not built is left out (tests/bench/packages.txt).

Every pose is timed once a round; its time is the least of all rounds, because on a shared machine everything else is someone
else's. Percentiles are over poses: p99 and worst are poses, not hiccups. `as it came` counts every tick of every round.
"""
import argparse
import datetime
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import contact_page

HERE = pathlib.Path(__file__).parent
PROGRAMS = ('bench_contact', 'bench_contact_dense', 'bench_contact_vdb', 'bench_contact_fcl', 'bench_contact_bullet', 'bench_contact_coal')
OURS, MESHES = PROGRAMS[0], PROGRAMS[3:]
MOTIONS = tuple(contact_page.MOTIONS)
SIZES = (1000, 10000, 100000, 1000000)
MAIN = (contact_page.MAIN_MOTION, contact_page.MAIN_VOXEL)  # the workload of the bars


class Program:
    """A benchmark program that is kept running and answers job by job."""

    def __init__(self, path, options):
        command = [str(path), '--budget', str(options.budget)] + (['--only', options.only] if options.only else [])
        self.name = path.name
        self.rivals = subprocess.run(command + ['--list'], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def answer(self, job):
        self.process.stdin.write('{} {} {}\n'.format(*job))
        self.process.stdin.flush()
        rows = []
        for line in self.process.stdout:
            if line == '\n':
                return rows
            rows.append(json.loads(line))
        sys.exit(f'{self.name} ended with {self.process.wait()} at {job}')


def jobs_of(options):
    """(motion, size, voxel in mm) and whether the peers run it too: sliding, and at 100 k points in all motions."""
    for voxel in options.voxel or (0.5, 0.25):
        for motion in options.motion or (MOTIONS if voxel == MAIN[1] else ('slide', 'free')):
            for size in options.size or (SIZES if motion in ('slide', 'free') else SIZES[1:3]):
                yield (motion, size, voxel), bool(options.motion) or motion == MAIN[0] or (size == 100000 and voxel == MAIN[1])


def wants(program, job, peers_too):
    """A mesh does not know the cells: its rival runs once."""
    if program.name == OURS:
        return True
    return peers_too and not (program.name in MESHES and (job[2] != MAIN[1] or job[0] == 'all' or job[1] > 100000))


def percentile(ordered, share):
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


class Row:
    """One rival on one job."""

    def __init__(self, first):
        self.facts = {key: value for key, value in first.items() if key != 'ns'}
        self.rounds = []

    def summary(self):
        least = sorted(map(min, zip(*self.rounds)))
        every = sorted(ns for one in self.rounds for ns in one)
        marks = {'p50': 0.5, 'p99': 0.99, 'p99.9': 0.999, 'max': 1}
        out = dict(self.facts, rounds=len(self.rounds), poses=len(least))
        out['least_ns'] = {name: percentile(least, share) for name, share in marks.items()}
        out['all_ns'] = {name: percentile(every, share) for name, share in marks.items()}
        out['ns_per_point'] = round(out['least_ns']['p50'] / self.facts['size'], 4)
        return out


def measure(options):
    programs = [Program(options.programs / name, options) for name in PROGRAMS if (options.programs / name).exists()]
    programs = [program for program in programs if program.rivals]
    summaries = []
    for job, peers_too in jobs_of(options):
        rows = {}
        taking_part = [program for program in programs if wants(program, job, peers_too)]
        for _ in range(options.rounds):
            for program in taking_part:
                for answer in program.answer(job):
                    rows.setdefault(answer['rival'], Row(answer)).rounds.append(answer['ns'])
        for row in rows.values():
            summaries.append(row.summary())
            tell(summaries[-1])
    return summaries


def tell(row):
    least, every = row['least_ns'], row['all_ns']
    print(f"{row['motion']:8} {row['size']:8} {row['voxel_mm']:5} {row['rival']:46} p50 {least['p50'] / 1e3:9.2f} us  p99 {least['p99'] / 1e3:9.2f}  "
          f"max {least['max'] / 1e3:9.2f}  as it came {every['p50'] / 1e3:9.2f} / {every['p99'] / 1e3:9.2f}", flush=True)


def instructions(options):
    """Instructions a tick of ours, by callgrind: a figure that repeats. {(mode, size): instructions}"""
    program, ticks, found = options.programs / OURS, 100, {}
    modes = subprocess.run([str(program), '--list', '--only', options.only], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    for mode in (line.split('\t')[1] for line in modes if 'AVX-512' not in line):  # valgrind has none
        for size in options.size or SIZES[:3]:
            with tempfile.TemporaryDirectory() as folder:
                command = ['valgrind', '--tool=callgrind', '--collect-atstart=no', '--toggle-collect=vxs_contact_evaluate',
                           f'--callgrind-out-file={folder}/out', str(program), '--only', mode, '--count', str(ticks)]
                log = subprocess.run(command, input=f'{MAIN[0]} {size} {MAIN[1]}\n', stderr=subprocess.PIPE, text=True, check=True).stderr
            total = re.search(r'Collected : (\d+)', log)
            found[mode, size] = int(total.group(1)) // ticks
            print(f'{mode}, {size} points: {found[mode, size]} instructions a tick', flush=True)
    return found


def scale(options):
    """Lines of bench_contact_scale as rows by (mode, path, points, scene)."""
    program, rows = options.programs / 'bench_contact_scale', {}
    if not program.exists():
        return []
    sizes = [str(size) for size in options.size or SIZES[2:]]
    out = subprocess.run([str(program), str(options.rounds), *sizes], stdout=subprocess.PIPE, text=True, check=True).stdout
    for line in out.splitlines():
        one = json.loads(line)
        key = one['mode'], one['path'], one['points'], one['scene']
        rows.setdefault(key, Row(dict(one, size=one['points']))).rounds.append(one['ns'])
    return [row.summary() for row in rows.values()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('programs', type=pathlib.Path, help='folder with bench_contact and its peers')
    parser.add_argument('--only', default='', help='rivals whose name contains this')
    parser.add_argument('--motion', nargs='+', choices=MOTIONS)
    parser.add_argument('--size', type=int, nargs='+', help='points, or triangles of a moving mesh')
    parser.add_argument('--voxel', type=float, nargs='+', help='[mm]')
    parser.add_argument('--rounds', type=int, default=7)
    parser.add_argument('--budget', type=float, default=0.5, help='seconds a rival, job and round')
    parser.add_argument('--nice', type=int, default=0, help='niceness of the programs; below 0 (as root) on a machine that others use')
    parser.add_argument('--instructions', action='store_true', help="count ours' instructions by callgrind too")
    parser.add_argument('--no-scale', action='store_true', help='leave out the scenes ten times finer and a hundred times larger')
    parser.add_argument('--dry', action='store_true', help='write nothing')
    parser.add_argument('--page', action='store_true', help='measure nothing: write the page again from the results')
    parser.add_argument('-o', '--output', type=pathlib.Path, default=HERE / 'results')
    options = parser.parse_args()
    record = options.output / 'contact.json'
    if not options.page:
        os.nice(options.nice)
        before = os.getloadavg()[0]
        compiler = subprocess.run(['c++', '--version'], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()[0]
        whole = not (options.only or options.motion or options.size or options.voxel or options.dry)
        data = {'date': datetime.date.today().isoformat(), 'machine': contact_page.machine(), 'compiler': compiler, 'rounds': options.rounds, 'nice': options.nice}

        def keep(**more):
            data.update(more, load=[before, os.getloadavg()[0]])
            if whole:  # whatever happens next
                options.output.mkdir(parents=True, exist_ok=True)
                record.write_text(contact_page.as_json(data), encoding='utf-8')
        keep(rows=measure(options))
        if not options.no_scale and not options.only:
            keep(scale=scale(options))
        if options.instructions:
            keep(instructions=[[*key, value] for key, value in instructions(options).items()])
        if not whole:
            return
    contact_page.write(json.loads(record.read_text(encoding='utf-8')), options.output)


if __name__ == '__main__':
    main()
