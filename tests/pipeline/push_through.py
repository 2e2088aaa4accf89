# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's figure 12a, made to hold: a hand pushes the sphere 8 mm into the cup's wall of 6 mm, at 0.1 and 0.3 m/s, rests there and
draws it out again, on every simulated device: push_through.py SAMPLES

As a user writes it (samples/scenes/cup_hold.scene.json: "design": "auto", no kind) nothing goes through:
- the body that feels the contact (with quasi-static it hangs on the device by a spring) is never past the
  middle of the wall, and the flag `deep` is never there;
- neither contact nor device ever pushes inwards, also on the way out, where a body that had come through is caught on the far side;
- in the end it is free, where the hand drew it.
Before it is drawn out it is still to three encoder steps.

Named kinds are held to less. quasi-static: contact is never a quarter of the wall deep, as its law counts depth, never `deep`, and never
pushes inwards. pt2, with a contact as stiff as the device carries in a hand at 6 dB: it must come to rest in the wall, which still pushes
back; on the way a fast or heavy device may come out of the far face for a moment. The paper's own field, one layer of surface cells, is
printed beside them.

A design also foretells how deep the body comes, on one axis, counted from where contact begins: asserted here against the run, with layers
as a bound (contact in steps is no line, and begins half a cell before the surface). Beside it stands how soon the device's peak
force at once would have stopped the device itself: what no coupling betters.
"""
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile

WALL, TOUCHES, REST = 0.006, 0.055, 0.3  # [m], x of the device where the sphere touches [m], the last seconds of the rest
FORETOLD = 2e-4  # [m]: a tenth of a cell
STEPS = {'touch': 55, 'omni': 55, 'desktop': 23, 'phantom-premium-1.5': 30, 'phantom-premium-3.0': 20, 'falcon': 38,  # encoder [um]
         'omega-3': 10, 'delta-3': 30, 'inverse3': 10, 'dlr-lwr': 50}
KILOHERTZ = {'omega-3': 4, 'delta-3': 4}
WAYS = (('auto', 'patch', 'layers'), ('auto', 'patch', 'distance'), ('pt2', 'patch', 'layers'), ('pt2', 'patch', 'distance'),
        ('quasi-static', 'average', 'layers'), ('quasi-static', 'gradient', 'distance'), ('pt2', 'average', 'surface'))


def run(*arguments):
    return subprocess.run([os.environ['VOXSHELL'], *arguments], stdout=subprocess.PIPE, text=True, check=True).stdout


def stiffness(device, rate):
    """Half of what the device carries in a hand without any filter but the widest [N/m]."""
    told = json.loads(run('design', '--device', f'sim:{device}', '--rate', rate, '--stiffness', '100N/m', '--assume', 'hand', '--format', 'json'))
    return told['k_max_n_per_m']['hand'] / 2


class Push:
    """One run: how far in the device went and came to rest [m], how still [encoder steps], the last force of the rest at the hand [N]; how
    deep contact was, as its law counts, and the body that feels it [m], whether contact or device ever pushed inwards, and whether it was
    free in the end."""

    def __init__(self, scene, folder, assets, speed, step):
        start, end = 0.075, 0.047
        arrives = 0.5 + (start - end) / speed
        leaves = arrives + 1.5
        back = leaves + (start - end) / speed
        scene['hand'] = {'path': [{'t': f'{t}s', 'position': [f'{x}m', '40mm', '0mm']}
                                  for t, x in ((0.5, start), (arrives, end), (leaves, end), (back, start))]}
        file = str(folder / 'push.scene.json')
        pathlib.Path(file).write_text(json.dumps(scene), encoding='utf-8')
        told = json.loads(run('simulate', file, '--assets', str(assets), '--seconds', f'{back + 0.5:.3f}',
                              '--force', '--trace', str(folder / 'push.csv'), '--format', 'json', '--quiet'))
        with open(folder / 'push.csv', newline='', encoding='utf-8') as trace:
            rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(trace)]
        x = [row['device_x_m'] for row in rows]
        rest = [row for row in rows if leaves - REST < row['t_s'] <= leaves]
        self.coupling = told['coupling']
        self.deepest, self.at_rest = TOUCHES - min(x), TOUCHES - rest[-1]['device_x_m']
        self.still = (max(row['device_x_m'] for row in rest) - min(row['device_x_m'] for row in rest)) / (step * 1e-6)
        self.force = rest[-1]['output_fx_n']
        self.felt, self.is_deep = told['depth_max_m'], 'deep' in told['flag_ticks']
        self.inwards = [min(row[key] for row in rows) < 0 for key in ('collision_fx_n', 'output_fx_n')]
        self.comes_out = rows[-1]['collision_fx_n'] == 0 and abs(rows[-1]['device_x_m'] - start) < 2e-3
        self.body, self.foretold, self.field = TOUCHES - min(row['body_x_m'] for row in rows if row['t_s'] > 0.5), None, scene['contact']['field']
        if 'kind' not in scene['coupling']:
            self.foretold = json.loads(run('design', file, '--assets', str(assets), '--format', 'json', '--quiet'))['push']

    def holds(self, coupling):
        if self.still >= 3 or self.force < 1:
            return False
        if coupling == 'pt2':
            return self.at_rest < WALL
        if coupling == 'quasi-static':
            return self.felt < WALL / 4 and not self.is_deep and not self.inwards[0]
        return self.body < WALL / 2 and not self.is_deep and not any(self.inwards) and self.comes_out and self.foretold['holds'] and \
            self.body < self.foretold['body_m'] + FORETOLD and (self.field != 'distance' or self.foretold['body_m'] < self.body + FORETOLD)

    def __str__(self):
        text = (f'device {1e3 * self.deepest:5.2f} mm in at most, {1e3 * self.at_rest:5.2f} at rest; contact {1e3 * self.felt:5.2f} mm deep; '
                f'{self.force:5.3f} N, {self.still:.1f} encoder steps')
        if self.foretold:
            text += (f'{"; PUSHED INWARDS" if any(self.inwards) else ""}{"" if self.comes_out else "; DOES NOT COME OUT"}; {self.coupling}; body {1e3 * self.body:.2f} mm in, foretold {1e3 * self.foretold["body_m"]:.2f}; '
                     f'at best {1e3 * self.foretold["device_at_best_m"]:.2f} mm')
        return text


def write(scene, hold, coupling, law, field):
    scene.update(json.loads(json.dumps(hold)))
    scene['contact'].update(law=law, field=field)
    if coupling != 'auto':
        scene['coupling']['kind'] = coupling
    if coupling == 'pt2':
        device = scene['device'].removeprefix('sim:')
        scene['contact'].update(stiffness='1e8N/m^3', most_stiffness=f'{stiffness(device, scene["rate"]):.0f}N/m')


def main():
    samples = pathlib.Path(sys.argv[1])
    hold = json.loads((samples / 'cup_hold.scene.json').read_text(encoding='utf-8'))
    assert 'kind' not in hold['coupling'] and 'most_stiffness' not in hold['contact']
    failed = 0
    with tempfile.TemporaryDirectory(prefix='voxshell-') as name:
        folder = pathlib.Path(name)
        for model in ('cup.glb', 'sphere.glb'):
            (folder / model).write_bytes((samples / model).read_bytes())
        for coupling, law, field in WAYS:
            scene, assets = {}, folder / field
            write(scene, hold, coupling, law, field)
            (folder / 'push.scene.json').write_text(json.dumps(scene), encoding='utf-8')
            run('convert', str(folder / 'push.scene.json'), '-o', str(assets), '--quiet', '--force')
            for device, step in STEPS.items():
                scene.update(device=f'sim:{device}', rate=f'{KILOHERTZ.get(device, 1)}kHz')
                if coupling == 'pt2':
                    scene['contact']['most_stiffness'] = f'{stiffness(device, scene["rate"]):.0f}N/m'
                for speed in (0.1, 0.3):
                    push = Push(scene, folder, assets, speed, step)
                    holds = push.holds(coupling)
                    print(f'{coupling:12} {law}/{field:8} {device:20} {speed} m/s  {push}  {"holds" if holds else "DOES NOT HOLD"}', flush=True)
                    failed += field != 'surface' and not holds
    sys.exit(f'{failed} do not hold' if failed else 0)


if __name__ == '__main__':
    main()
