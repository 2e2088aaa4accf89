# SPDX-License-Identifier: GPL-3.0-or-later
"""How soon a page of `voxshell view` opens, and how fluid it is, in chromium that draws in software: a page of Markdown, with --json its numbers too.

    python3 tests/bench/view.py build/release/bin/voxshell [--json FILE] [NAME=FILE,FILE ...] > tests/bench/results/view.md

Without a NAME=FILE the samples' cup, and cup and sphere in a million cells."""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

SOURCE = pathlib.Path(__file__).parents[2]
sys.path.insert(0, str(SOURCE / 'tests/cli'))
import browser  # noqa: E402

WIDE, HIGH, PANEL, FRAMES, WARM = 1280, 720, 320, 150, 30
ORBIT = '''new Promise(done => {
    const times = [], faces = [];
    const step = now => {
        times.push(now);
        faces.push(voxshell.drawn.faces);
        if (times.length > %d) return done({times, faces, edge: voxshell.coarse});
        voxshell.turn(0.03, 0.004 * Math.sin(times.length / 20));
        voxshell.touch();
        requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
})''' % (FRAMES + WARM)


def settle(seen):
    end = time.monotonic() + 120
    while not seen.run('window.voxshell && voxshell.drawn.full && voxshell.drawn.sharp'):
        if time.monotonic() > end:
            raise TimeoutError(seen.run("document.getElementById('say').textContent"))
        time.sleep(0.05)


def measure(page, repeats):
    """The best of `repeats` times of opening and turning: another program takes time from the browser, and never gives it any."""
    runs = []
    for _ in range(repeats):
        with browser.Browser(browser.find(), seconds=180, graphics=browser.SOFTWARE_GL) as seen:
            seen.open(page, WIDE + PANEL, HIGH)
            settle(seen)
            size = seen.run('[voxshell.canvas.clientWidth, voxshell.canvas.clientHeight]')
            assert size == [WIDE, HIGH], size
            run = seen.run('({opened: voxshell.opened, complete: voxshell.complete, faces: voxshell.drawn.faces})')
            seen.run('voxshell.fewest = 1')
            orbit = seen.run(ORBIT)
            assert not seen.errors, seen.errors[:3]
        frames = sorted(b - a for a, b in zip(orbit['times'][WARM:], orbit['times'][WARM + 1:]))
        run.update(fps=1000 * len(frames) / sum(frames), p50=frames[len(frames) // 2], p95=frames[int(0.95 * len(frames))], worst=frames[-1],
                   moving_faces=orbit['faces'][-1], edge=orbit['edge'])
        runs.append(run)
    best = max(runs, key=lambda run: run['fps'])
    return {**best, 'opened': min(r['opened'] for r in runs), 'complete': min(r['complete'] for r in runs), 'fps_worst': min(r['fps'] for r in runs)}


def head(tool):
    cpu = next((line.split(':')[1].strip() for line in open('/proc/cpuinfo', encoding='utf-8') if line.startswith('model name')), 'unknown processor')
    seen = subprocess.run([browser.find(), '--version'], capture_output=True, text=True, check=False).stdout.strip()
    return f'''# Pages without a graphics card

{cpu}, {os.cpu_count()} cores; {seen}, WebGL by SwiftShader; {subprocess.run([tool, '--version'], capture_output=True, text=True, check=True).stdout.strip()}; load before {os.getloadavg()[0]:.1f}.

`tests/bench/view.py` makes this page. The canvas is {WIDE} x {HIGH}. Opens: from the navigation to the first frame; full: to the first frame in full detail. Orbit: a turn of the view at each animation frame, {FRAMES} of them
after {WARM}; at 60 Hz none is faster than 16.7 ms. A page that is too slow at the coarsest draws fewer pixels; here it must not. Frames a second are the best of several rounds and the worst, since other programs take time from the browser and never give it any. Rectangles are what faces are merged into: at
rest, and in the last frame of the orbit, where an edge of a cell has so many pixels.

| page | surface cells | points | size | made in | opens | full | frames/s | worst round | p95 | rectangles | moving | edge |
|---|---|---|---|---|---|---|---|---|---|---|---|---|'''


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('voxshell')
    parser.add_argument('pages', nargs='*', metavar='NAME=FILE,FILE')
    parser.add_argument('--json')
    parser.add_argument('--repeats', type=int, default=3)
    options = parser.parse_args()
    tool = os.path.abspath(options.voxshell)
    samples = pathlib.Path(tool).parents[1] / 'samples'
    results = []
    with tempfile.TemporaryDirectory(prefix='voxshell-') as folder:
        def run(*arguments):
            return subprocess.run([tool, *map(str, arguments)], cwd=folder, check=True, capture_output=True, text=True).stdout
        pages = dict(page.split('=', 1) for page in options.pages)
        if not pages:
            for part, voxel, name in (('sphere', '0.0645mm', 'fine'), ('cup', '0.235mm', 'cup'), ('cup', '1mm', 'coarse')):
                run('convert', samples / f'{part}.glb', '--voxel', voxel, '-o', name, '-q')
            pages = {'cup, 1 mm': 'coarse/cup.voxmap', 'cup, 0.235 mm': 'cup/cup.voxmap', 'sphere, 64.5 um': 'fine/sphere.voxmap',
                     'the same with its points': 'fine/sphere.voxmap,fine/sphere.pointshell'}
        print(head(tool))
        for name, files in pages.items():
            begin = time.monotonic()
            told = json.loads(run('view', *files.split(','), '-o', 'page.html', '--force', '--format', 'json', '-q'))
            made = time.monotonic() - begin
            found = measure(pathlib.Path(folder, 'page.html'), options.repeats)
            count = lambda what: sum(body.get(what, 0) for body in told['bodies'])
            results.append({'page': name, 'surface_cells': count('surface_cells'), 'points': count('points'), 'bytes': told['page']['bytes'], 'made_s': made, **found})
            print(f'| {name} | {count("surface_cells"):,} | {count("points"):,} | {told["page"]["bytes"] / 1024:.0f} KiB | {made:.1f} s | {found["opened"] / 1000:.2f} s | {found["complete"] / 1000:.2f} s '
                  f'| {found["fps"]:.0f} | {found["fps_worst"]:.0f} | {found["p95"]:.0f} ms | {found["faces"]:,} | {found["moving_faces"]:,} | {found["edge"]:.1f} px |', flush=True)
    print(f'\nLoad after: {os.getloadavg()[0]:.1f}.')
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps(results, indent=1) + '\n', encoding='utf-8')


if __name__ == '__main__':
    main()
