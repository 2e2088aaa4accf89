# SPDX-License-Identifier: GPL-3.0-or-later
"""results/contact.md and its plot from what contact.py measured."""
import json
import os
import pathlib
import re
import subprocess

OURS = 'voxshell'
MOTIONS = {'slide': 'on the inner wall, 0.25 mm deep', 'outside': 'on the outer wall, 0.25 mm deep', 'grazing': 'on the inner wall, 0.02 mm deep',
           'deep': 'in the wall, 1.5 mm deep', 'free': 'in the cup, 15 mm from the wall', 'all': 'every point in contact'}
MAIN_MOTION, MAIN_VOXEL = 'slide', 0.5
SCENES = {'finer': 'ten times finer, the same path', 'larger': 'a hundred cups, the sphere in one', 'hopping': 'a hundred cups, in another one every tick'}


def as_json(data):
    """One row a line, so that a change shows."""
    parts = []
    for key, value in data.items():
        if isinstance(value, list) and value and isinstance(value[0], (dict, list)):
            parts.append(f'"{key}": [\n' + ',\n'.join(json.dumps(row) for row in value) + '\n]')
        else:
            parts.append(f'"{key}": {json.dumps(value)}')
    return '{\n' + ',\n'.join(parts) + '\n}\n'


def machine():
    """The processor's name and its caches."""
    text = pathlib.Path('/proc/cpuinfo').read_text(encoding='utf-8')
    found = re.search(r'model name\s*: (.*)', text)
    caches = []
    for index in sorted(pathlib.Path('/sys/devices/system/cpu/cpu0/cache').glob('index*')):
        level, kind, size = ((index / name).read_text(encoding='utf-8').strip() for name in ('level', 'type', 'size'))
        if kind != 'Instruction':
            caches.append(f'L{level} {size}')
    return f"{found.group(1).strip() if found else 'unknown processor'}, {os.cpu_count()} cores, {', '.join(caches)}"


def micro(ns):
    us = ns / 1e3
    return f'{us:.2f}' if us < 10 else f'{us:.1f}' if us < 100 else f'{us:.0f}'


def count(n):
    return f'{n // 1000000} M' if n >= 1000000 else f'{n // 1000} k'


class Results:
    def __init__(self, data):
        self.data = data
        self.row = {(r['rival'], r['motion'], r['size'], r['voxel_mm']): r for r in data['rows']}

    def select(self, **wanted):
        return [r for r in self.data['rows'] if all(r[key] == value for key, value in wanted.items())]

    def p50(self, rival, motion, size, voxel=MAIN_VOXEL):
        found = self.row.get((rival, motion, size, voxel))
        return found['least_ns']['p50'] if found else None

    def rivals(self, **wanted):
        return list(dict.fromkeys(r['rival'] for r in self.select(**wanted)))

    def ours(self, *words):
        return [name for name in self.rivals() if name.startswith(OURS) and all(word in name for word in words)]

    def best(self, motion, size, voxel=MAIN_VOXEL, words=()):
        """Our fastest row that looks at all points that matter: (p50, name); (None, None) without any."""
        rows = [(self.p50(name, motion, size, voxel), name) for name in self.ours(*words) if 'at most' not in name]
        return min((row for row in rows if row[0]), default=(None, None))


def bars(results):
    """What is asked (the project's own bars), what was measured."""
    def times(peer, ours, size=100000):
        theirs, mine = results.p50(peer, MAIN_MOTION, size), ours[0]
        return theirs / mine if theirs and mine else None

    for what, bar, words, size in (('states, brute, AVX2, 100 k points, whole tick', 1.1, ('states', 'brute', 'AVX2'), 100000),
                                   ('distance, brute, AVX2, 100 k points, whole tick', 2.0, ('distance', 'brute', 'AVX2'), 100000)):
        mine = results.best(MAIN_MOTION, size, words=words)[0]
        if mine:
            yield f'{what} [ns a point]', '<=', bar, mine / size
    for size, bar in ((10000, 4), (100000, 25), (1000000, 250)):
        mine = results.best(MAIN_MOTION, size, words=('states',))[0]
        if mine:
            yield f'sliding, {count(size)} points, fastest mode [us]', '<=', bar, mine / 1e3
    free = [results.best('free', size)[0] for size in (1000, 10000, 100000, 1000000)]
    if all(free):
        yield 'free, 15 mm from the wall, the largest of all sizes, fastest mode [us]', '<=', 1, max(free) / 1e3
    best = results.best(MAIN_MOTION, 100000)
    for peer, bar in (('FCL, OBBRSS', 40), ('Coal, OBBRSS, break distance 1 um', 40), ('Bullet btGImpact', 100)):
        value = times(peer, best)
        if value:
            yield f'times faster than {peer}, 100 k triangles to 100 k points', '>=', bar, value
    states, distance = (results.best(MAIN_MOTION, 100000, words=(kind, 'brute')) for kind in ('states', 'distance'))
    for peer in ('OpenVDB accessor', 'NanoVDB accessor', 'PNanoVDB.h'):
        value = times(f'{peer}, nearest', states)
        if value:
            yield f'times faster than {peer}, nearest, brute against brute', '>=', 7, value
        value = times(f'{peer}, trilinear', distance)
        if value:
            yield f'times faster than {peer}, trilinear, brute against brute (distance)', '>=', 20, value


def bars_table(results):
    lines = ['| | bar | measured | |', '|---|---|---|---|']
    for what, sign, bar, value in bars(results):
        holds = value <= bar if sign == '<=' else value >= bar
        lines.append(f"| {what} | {sign} {bar} | {value:.3g} | {'holds' if holds else '**missed**'} |")
    return lines


def ratio_table(results, kind):
    """How many times the fastest of ours each needs, sliding."""
    wanted = dict(kind=kind, motion=MAIN_MOTION, voxel_mm=MAIN_VOXEL)
    sizes = sorted({r['size'] for r in results.select(**wanted)})
    unit = 'points' if kind == 'points' else 'triangles'
    lines = ['| | ' + ' | '.join(f'{count(size)} {unit}' for size in sizes) + ' |', '|---|' + '---|' * len(sizes)]
    for rival in results.rivals(**wanted):
        cells = []
        for size in sizes:
            theirs, ours = results.p50(rival, MAIN_MOTION, size), results.best(MAIN_MOTION, size)[0]
            cells.append(f'{theirs / ours:.3g} × ({micro(theirs)} µs)' if theirs and ours else '')
        lines.append(f'| {rival} | ' + ' | '.join(cells) + ' |')
    return lines


def share(value, digits):
    return '' if value is None else f'{100 * value:+.{digits}f} %'


def detail_table(results, motion, size, voxel):
    rows = results.select(kind='points', motion=motion, size=size, voxel_mm=voxel)
    lines = ['| | ns a point | p50 | p99 | p99.9 | worst pose | as it came: p50 / p99 / max | in contact | looked at | force | static MiB |', '|---|' + '---|' * 10]
    for r in rows:
        least, every = r['least_ns'], r['all_ns']
        touched = '' if r['touched'] is None else f"{r['touched']:.0f}"
        lines.append(f"| {r['rival']} | {r['ns_per_point']:.3g} | " + ' | '.join(micro(least[mark]) for mark in ('p50', 'p99', 'p99.9', 'max')) +
                     f" | {micro(every['p50'])} / {micro(every['p99'])} / {micro(every['max'])} | {r['contacts']:.0f} | {touched} | "
                     f"{share(r.get('force_error'), 1)} | {r['static_mib']:.1f} |")
    return lines


def motion_table(results, size, voxel):
    motions = [m for m in MOTIONS if results.select(motion=m, size=size, voxel_mm=voxel)]
    lines = ['| p50 (worst pose) [µs] | ' + ' | '.join(motions) + ' |', '|---|' + '---|' * len(motions)]
    for rival in results.rivals(size=size, voxel_mm=voxel):
        cells = []
        for motion in motions:
            row = results.row.get((rival, motion, size, voxel))
            cells.append(f"{micro(row['least_ns']['p50'])} ({micro(row['least_ns']['max'])})" if row else '')
        lines.append(f'| {rival} | ' + ' | '.join(cells) + ' |')
    return lines


def ours_table(results, voxel):
    """Every size and motion of ours."""
    sizes = sorted({r['size'] for r in results.select(voxel_mm=voxel, kind='points')})
    lines = []
    for motion, meaning in MOTIONS.items():
        rows = results.select(kind='points', motion=motion, voxel_mm=voxel)
        if not any(r['rival'].startswith(OURS) for r in rows):
            continue
        lines += [f'| {motion}: {meaning} | ' + ' | '.join(f'{count(size)}' for size in sizes) + ' |', '|---|' + '---|' * len(sizes)]
        for rival in (name for name in results.rivals(motion=motion, voxel_mm=voxel) if name.startswith(OURS)):
            cells = []
            for size in sizes:
                row = results.row.get((rival, motion, size, voxel))
                cells.append(f"{micro(row['least_ns']['p50'])} ({micro(row['least_ns']['max'])}), {row['touched']:.0f}" if row else '')
            lines.append(f'| {rival} | ' + ' | '.join(cells) + ' |')
        lines.append('')
    return lines


def mesh_table(results):
    rows = results.select(kind='mesh', motion=MAIN_MOTION)
    lines = ['| | triangles | p50 | p99 | worst pose | contacts | deepest [mm] (true: 0.25) |', '|---|---|---|---|---|---|---|']
    for r in rows:
        least = r['least_ns']
        lines.append(f"| {r['rival']} | {count(r['size'])} | {micro(least['p50'])} | {micro(least['p99'])} | {micro(least['max'])} | {r['contacts']:.0f} | {r['depth_mm']:.3f} |")
    return lines


def scale_table(data):
    row = {(r['mode'], r['path'], r['points'], r['scene']): r for r in data['scale']}
    lines = ['| mode, path, points | cup [µs] | ' + ' | '.join(SCENES.values()) + ' |', '|---|---|' + '---|' * len(SCENES)]
    for mode, path, points in dict.fromkeys(key[:3] for key in row):
        base = row[mode, path, points, 'cup']
        cells = []
        for scene in SCENES:
            r = row[mode, path, points, scene]
            cells.append(f"{100 * (r['least_ns']['p50'] / base['least_ns']['p50'] - 1):+.0f} % ({micro(r['least_ns']['p50'])}), {r['contacts']:.0f} in contact")
        lines.append(f"| {mode}, {path}, {count(points)} | {micro(base['least_ns']['p50'])}, {base['contacts']:.0f} in contact | " + ' | '.join(cells) + ' |')
    size = {r['scene']: r['map_mib'] for r in data['scale']}
    return lines + ['', 'Maps: ' + ', '.join(f'{scene} {mib:.1f} MiB' for scene, mib in size.items()) + '.']


def page(data):
    results = Results(data)
    nice = f", programs at niceness {data['nice']}" if data['nice'] else ''
    lines = [
        '# The contact engine beside its peers', '',
        f"{data['machine']}; {data['compiler']}; one thread; {data['date']}; load before {data['load'][0]:.1f}, after {data['load'][1]:.1f}{nice}. "
        f"{data['rounds']} rounds, the programs taking turns.", '',
        'Ours is compiled as shipped: kernels -O3, the rest of the tick -O2 or -Os, -ffp-contract=off, no -march, the kernel chosen at run time. Peers that a user would compile (dense, OpenVDB, '
        'NanoVDB) get -O3 -march=x86-64-v3 and fused multiply-add; FCL, Bullet and Coal are as packaged. `tests/bench/contact.py` makes this page and says how times are taken: '
        "a pose's time is the least of all rounds, percentiles are over the 1000 poses; \"as it came\" counts every tick. Ticks from 0.1 ms on are in the thread's own processor time, shorter ones by the clock.", '',
        data.get('note', ''), '',
        'Static: the cup, outer radius 40 mm, height 90 mm, wall and floor 3 mm, 102 600 triangles. Moving: a sphere of radius 12 mm as evenly spread points in clusters of 64, or as a mesh; '
        '0.1 mm a tick along the wall, rolling. A tick is all from pose to wrench. For a mesh it is all from pose to contacts, without a force.', '',
        '## Bars', ''] + bars_table(results) + [
        '', '## Sliding, 0.5 mm cells: times the fastest of ours', ''] + ratio_table(results, 'points') + [
        '', 'Mesh against mesh, its triangles against as many of our points:', ''] + ratio_table(results, 'mesh') + [
        '', '![tick over size](contact.svg)']
    for size, voxel in ((100000, 0.5), (1000000, 0.5), (100000, 0.25)):
        lines += ['', f'## Sliding, {count(size)} points, {voxel} mm cells [µs]', '']
        lines += detail_table(results, MAIN_MOTION, size, voxel)
        if (size, voxel) == (100000, 0.5):
            lines += ['', '"force": error of the length of the summed force against exact distances from the mesh, mean over poses. Nearest reads the value of the cell\'s centre; '
                      'states with a tangent plane is the law that the haptic method defines.']
    lines += ['', '## Motions, 100 k, 0.5 mm cells', ''] + [f'- {m}: {meaning}' for m, meaning in MOTIONS.items()] + [''] + motion_table(results, 100000, 0.5)
    for voxel in (0.5, 0.25):
        lines += ['', f'## Ours, {voxel} mm cells: p50 (worst pose) [µs], points looked at', ''] + ours_table(results, voxel)
    lines += ['## Mesh against mesh, sliding [µs]', ''] + mesh_table(results)
    if data.get('scale'):
        lines += ['', '## A larger static part (`bench_contact_scale`)', '', 'p50 of ours against that of the one cup in cells of 0.5 mm, ticks taking turns; the bar is 10 %, 25 % with cache effects. '
                  'In cells of 0.05 mm a point 0.25 mm deep is beneath the layer and counts as deep: fewer are in contact.', ''] + scale_table(data)
    if data.get('instructions'):
        lines += ['', '## Instructions a tick, sliding, 0.5 mm cells (callgrind)', '', '| mode | points | instructions | a point |', '|---|---|---|---|']
        lines += [f'| {mode} | {count(size)} | {n} | {n / size:.3g} |' for mode, size, n in data['instructions']]
    return re.sub(r'\n{3,}', '\n\n', '\n'.join(lines)) + '\n'


def style(rival):
    """A family has a colour, a member its own mark; ours are thick."""
    families = (('voxshell states', "'#c00000'", 3), ('voxshell distance', "'#e07000'", 3), ('dense', "'#2060c0'", 1.3), ('OpenVDB', "'#108040'", 1.3),
                ('NanoVDB', "'#30b060'", 1.3), ('PNanoVDB', "'#80c040'", 1.3))
    colour, width = next(((c, w) for name, c, w in families if rival.startswith(name)), ("'#606060'", 1.3))
    marks = {'coherent': 7, 'culled': 6, 'brute': 5, 'nearest': 4, 'trilinear': 8, 'as it comes': 12, 'FCL': 2, 'Bullet': 3}
    mark = next((m for word, m in marks.items() if word in rival), 1)
    dashed = 3 if 'scalar' in rival else 2 if 'voxshell' in rival and 'AVX2' in rival else 1
    return f'lc rgb {colour} lw {width} dt {dashed} pt {mark} ps 0.6'


def plot(data, path):
    """Tick over size, both logarithmic: ours thick."""
    results = Results(data)
    curves = []
    for rival in results.rivals(motion=MAIN_MOTION, voxel_mm=MAIN_VOXEL):
        rows = sorted((r['size'], r['least_ns']['p50'] / 1e3) for r in results.select(rival=rival, motion=MAIN_MOTION, voxel_mm=MAIN_VOXEL))
        if 'original law' not in rival and 'at most' not in rival:
            curves.append((rival, rows))
    curves.sort(key=lambda curve: -max(curve[1])[1])
    blocks = '\n\n\n'.join('\n'.join(f'{x} {y}' for x, y in rows) for _, rows in curves)
    styles = ', '.join(f"$d index {n} with linespoints {style(rival)} title '{rival}'" for n, (rival, _) in enumerate(curves))
    script = f"""$d << EOD
{blocks}
EOD
set terminal svg size 960,680 font 'sans-serif,11' background '#ffffff'
set output '{path}'
set logscale xy
set title 'Sphere sliding on the cup, 0.5 mm cells, one thread'
set xlabel 'points, or triangles of the moving mesh'
set ylabel 'tick, p50 [us]'
set xrange [800:1250000]
set xtics ('1 k' 1000, '10 k' 10000, '100 k' 100000, '1 M' 1000000)
set grid ytics lc rgb '#dddddd'
set key outside right center maxcols 1 noenhanced Left reverse samplen 3 spacing 0.95
plot {styles}
"""
    subprocess.run(['gnuplot'], input=script, text=True, check=True)


def write(data, folder):
    text = page(data)
    print(text)
    (folder / 'contact.md').write_text(text, encoding='utf-8')
    plot(data, folder / 'contact.svg')
