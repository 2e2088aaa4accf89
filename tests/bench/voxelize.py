# SPDX-License-Identifier: GPL-3.0-or-later
"""The voxeliser beside its peers, one mesh, one machine, one run after the other, interleaved:
    ninja -C build/release bench && python3 tests/bench/voxelize.py build/release/bin
Prints a table against the bars, and writes results/voxelize-CPU.md and .svg. A peer that is not built or not installed is
left out (VTK: --vtk-python names a Python that has it).
"""
import argparse
import datetime
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
OURS = ('surface', 'solid', 'distance')


def commands(options):
    folder = options.programs
    table = {f'voxshell {mode}': [folder / 'bench_voxelize', mode, '{cells}', '1'] for mode in OURS}
    table['dense 1 thread'] = [folder / 'bench_voxelize_dense', '{cells}', '1', '1']
    table['dense 2 threads'] = [folder / 'bench_voxelize_dense', '{cells}', '1', '2']
    table['OpenVDB solid'] = [folder / 'bench_voxelize_openvdb', 'solid', '{cells}', '1']
    table['OpenVDB level set'] = [folder / 'bench_voxelize_openvdb', 'level-set', '{cells}', '1']
    table['VTK stencil'] = [options.vtk_python, HERE / 'bench_voxelize_vtk.py', '{cells}', '1']
    return table


def measure(command, cells):
    """One run, or None where the peer is not here."""
    try:
        done = subprocess.run([str(part).format(cells=cells) for part in command], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    except FileNotFoundError:
        return None
    if done.returncode == 77:
        return None
    if done.returncode:
        sys.exit(f'{command[0]} ended with {done.returncode}')
    return json.loads(done.stdout.splitlines()[-1])


def cpu():
    text = pathlib.Path('/proc/cpuinfo').read_text(encoding='utf-8')
    found = re.search(r'model name\s*: (.*)', text)
    return found.group(1).strip() if found else 'unknown'


class Results:
    def __init__(self):
        self.seconds, self.peak = {}, {}  # (name, cells) -> list

    def add(self, name, cells, run):
        self.seconds.setdefault((name, cells), []).append(run['seconds'])
        self.peak.setdefault((name, cells), []).append(run['peak_mib'])

    def median(self, name, cells):
        return statistics.median(self.seconds[name, cells])

    def bars(self, cells):
        """What is asked, how much of it there is; what cannot be told for want of a peer is left out."""
        def faster(ours, peer):
            return self.median(peer, cells) / self.median(ours, cells)

        def memory(ours, peer):
            return max(self.peak[ours, cells]) / max(self.peak[peer, cells])
        rows = (('surface + interior, times faster than OpenVDB solid', '>= 20', ('voxshell solid', 'OpenVDB solid'), faster, lambda x: x >= 20),
                ('surface + interior, times faster than VTK stencil', '> 1', ('voxshell solid', 'VTK stencil'), faster, lambda x: x > 1),
                ('surface + interior, times the dense surface-only voxeliser, two threads', '<= 1.5', ('dense 2 threads', 'voxshell solid'), faster, lambda x: x <= 1.5),
                ('with distance, times faster than OpenVDB level set', '>= 5', ('voxshell distance', 'OpenVDB level set'), faster, lambda x: x >= 5),
                ('peak memory, surface + interior, of OpenVDB solid', '< 0.25', ('voxshell solid', 'OpenVDB solid'), memory, lambda x: x < 0.25),
                ('peak memory, with distance, of OpenVDB level set', '< 0.25', ('voxshell distance', 'OpenVDB level set'), memory, lambda x: x < 0.25))
        for what, bar, names, measured, holds in rows:
            if all((name, cells) in self.seconds for name in names):
                value = measured(*names)
                yield what, bar, value, holds(value)


def page(results, sizes, options, load):
    names = [name for name in commands(options) if any((name, cells) in results.seconds for cells in sizes)]
    lines = ['# The voxeliser beside its peers', '',
             f'Cup of 102 600 triangles, cells along its 90 mm; {options.runs} runs each, interleaved. {cpu()}, {os.cpu_count()} cores, two threads;',
             f'{datetime.date.today()}; load before {load[0]:.1f}, after {load[1]:.1f}' +
             (': the machine was busy with other work, read ratios, not digits.' if max(load) > 3 else '.'), '',
             '| seconds: median (min .. max), peak MiB | ' + ' | '.join(map(str, sizes)) + ' |', '|---|' + '---|' * len(sizes)]
    for name in names:
        cells = []
        for size in sizes:
            runs = results.seconds.get((name, size))
            cells.append(f'{statistics.median(runs):.3f} ({min(runs):.3f} .. {max(runs):.3f}), {max(results.peak[name, size])}' if runs else '')
        lines.append(f'| {name} | ' + ' | '.join(cells) + ' |')
    lines += ['', f'Bars at {sizes[-1]} cells:', '', '| | bar | measured | |', '|---|---|---|---|']
    lines += [f'| {what} | {bar} | {value:.2f} | {"holds" if holds else "**missed**"} |' for what, bar, value, holds in results.bars(sizes[-1])]
    return '\n'.join(lines) + '\n'


def plot(results, sizes, path, options):
    """Seconds over cells, both logarithmic."""
    names = [name for name in commands(options) if any((name, cells) in results.seconds for cells in sizes)]
    data = '\n\n\n'.join('\n'.join(f'{cells} {results.median(name, cells)}' for cells in sizes if (name, cells) in results.seconds) for name in names)
    curves = ', '.join(f"$d index {n} with linespoints lw {3 if name.startswith('voxshell') else 1.5} pt {5 + n % 10} ps 0.6 "
                       f"dt {1 if name.startswith('voxshell') else 2} title '{name}'" for n, name in enumerate(names))
    script = f"""$d << EOD
{data}
EOD
set terminal {'pngcairo' if path.suffix == '.png' else 'svg'} size 760,460 font 'sans-serif,12' background '#ffffff'
set output '{path}'
set logscale xy
set xlabel 'cells along the longest side'
set ylabel 'seconds'
set xtics ({', '.join(f"'{cells}' {cells}" for cells in sizes)})
set xrange [{sizes[0] * 0.9}:{sizes[-1] * 1.1}]
set grid ytics lc rgb '#dddddd'
set key outside right center
plot {curves}
"""
    subprocess.run(['gnuplot'], input=script, text=True, check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('programs', type=pathlib.Path, help='folder with bench_voxelize and its peers')
    parser.add_argument('--cells', type=int, nargs='+', default=[128, 256, 512, 1024])
    parser.add_argument('--runs', type=int, default=3)
    parser.add_argument('--vtk-python', default=sys.executable)
    parser.add_argument('-o', '--output', type=pathlib.Path, default=HERE / 'results')
    options = parser.parse_args()
    results, sizes, before = Results(), sorted(options.cells), os.getloadavg()[0]
    for cells in sizes:
        for run in range(options.runs):
            for name, command in commands(options).items():
                one = measure(command, cells)
                if one:
                    results.add(name, cells, one)
                    print(f"{cells} {name}: {one['seconds']:.3f} s, {one['peak_mib']} MiB", file=sys.stderr)
    text = page(results, sizes, options, (before, os.getloadavg()[0]))
    print(text)
    options.output.mkdir(parents=True, exist_ok=True)
    name = 'voxelize-' + re.sub(r'[^a-z0-9]+', '-', cpu().lower()).strip('-')
    (options.output / f'{name}.md').write_text(text + f'\n![seconds over cells]({name}.svg)\n', encoding='utf-8')
    plot(results, sizes, options.output / f'{name}.svg', options)


if __name__ == '__main__':
    main()
