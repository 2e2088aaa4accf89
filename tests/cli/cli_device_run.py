# SPDX-License-Identifier: GPL-3.0-or-later
"""simulate and device on what is not a plain simulated device: noise, delay and drop-outs, replays in text and binary, hardware at the end of a
pseudo-terminal (samples/hvlink_device, a process of its own), its refusals, its end by each signal, a known mass, and the live view."""
import csv
import json
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import command
import schema

SAMPLES = pathlib.Path(os.environ['VOXSHELL_BUILD'], 'samples')
BIN = pathlib.Path(os.environ['VOXSHELL_BUILD'], 'bin')
DEVICE = schema.load(command.SOURCE / 'formats/schema/device.schema.json')
LIVE = schema.load(command.SOURCE / 'formats/schema/live.schema.json')
GUARDS = {'only start-inside': [{'kind': 'start-inside'}], 'only soft-start': [{'kind': 'soft-start'}], 'none': []}


def on_busy_machines(test):
    """A machine that stalls either side for long enough makes its watchdog act, as it should: then once more."""
    def run(self):
        for tries in range(5):
            try:
                return test(self)
            except AssertionError as error:
                if tries == 4 or not re.search('watchdog|deadman|moved too fast|device ARMED|does not push', str(error)):
                    raise
    run.__doc__ = test.__doc__
    return run


class Running(command.CommandTest):
    @classmethod
    def setUpClass(cls):
        cls.assets = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.assets.cleanup)
        subprocess.run([command.BIN, 'convert', SAMPLES / 'cup_hold.scene.json', '-o', cls.assets.name, '-q'], check=True, stdout=subprocess.DEVNULL)

    def setUp(self):
        super().setUp()
        for name in ('cup.glb', 'sphere.glb', 'cup_hold.scene.json'):
            shutil.copy(SAMPLES / name, self.folder)
        shutil.copytree(self.assets.name, self.folder / 'assets')

    def simulate(self, *arguments, code=0, scene='cup_hold.scene.json'):
        done = self.run_voxshell('simulate', scene, '--assets', 'assets', '--format', 'json', *arguments, code=code)
        return json.loads(done.stdout) if done.stdout else done.stderr

    def trace(self, name):
        with open(self.path(name), encoding='utf-8', newline='') as file:
            return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]

    def device(self, *arguments):
        """An hvlink device: its process, and how it is named."""
        process = subprocess.Popen([BIN / 'sample_hvlink_device', *arguments], stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        path = process.stdout.readline().strip()
        if not path:
            self.skipTest('no pseudo-terminals here')
        return process, f'hvlink:{path}'

    def end(self, process):
        """What its motors did: most, last [N], oldest command that was followed [ms]."""
        process.send_signal(signal.SIGTERM)
        said = process.stdout.readline()
        process.wait(timeout=10)
        return tuple(float(n) for n in re.match(r'([\d.]+) N at most, ([\d.]+) N at the end, .* older than ([\d.]+) ms', said).groups())

    # --- simulated

    def test_noise(self):
        told = self.simulate('--device', 'sim:falcon,noise=100um,seed=7', '--seconds', '0.4', '--trace', 'a.csv')
        self.assertEqual(told['device'], 'sim:falcon,noise=100um,seed=7')
        self.simulate('--device', 'sim:falcon,noise=100um,seed=7', '--seconds', '0.4', '--trace', 'b.csv')
        self.simulate('--device', 'sim:falcon,noise=100um,seed=8', '--seconds', '0.4', '--trace', 'c.csv')
        self.assertEqual(pathlib.Path(self.path('a.csv')).read_bytes(), pathlib.Path(self.path('b.csv')).read_bytes())
        self.assertNotEqual(pathlib.Path(self.path('a.csv')).read_bytes(), pathlib.Path(self.path('c.csv')).read_bytes())
        y = [row['device_y_m'] - 0.04 for row in self.trace('a.csv')]  # the hand is still for half a second
        self.assertAlmostEqual(math.sqrt(sum(v * v for v in y) / len(y)) / 1e-4, 1, delta=0.15)

    def test_drop_outs(self):
        told = self.simulate('--device', 'sim:falcon,loss=20%,loss-time=5ms')
        self.assertAlmostEqual(told['flag_ticks']['stale'] / told['ticks'], 0.2, delta=0.06)
        self.assertNotIn('fault', told['flag_ticks'])
        self.assertNotIn('stale', self.simulate('--device', 'sim:falcon')['flag_ticks'])

    def test_delay(self):
        """The delay is the device's: the same scene designs a softer coupling for it."""
        self.assertNotEqual(self.simulate('--device', 'sim:falcon,delay=12')['coupling'], self.simulate('--device', 'sim:falcon')['coupling'])

    def test_refused_options(self):
        for name in ('sim:falcon,noise=1', 'sim:falcon,noise', 'sim:falcon,loss=95%', 'sim:falcon,loss=0.1', 'sim:falcon,delay=0', 'sim:falcon,delay=65',
                     'sim:falcon,seed=-1', 'sim:falcon,seed=1,seed=2', 'sim:falcon,loss-time=11s', 'sim:falcon,', 'sim:falcon,wobble=1', 'sim:falcon,noise=nan'):
            with self.subTest(name):
                self.assertIn('after the name may stand', self.simulate('--device', name, code=1))

    # --- replayed

    def test_replay(self):
        """A recording, binary, gives the same forces again to the last digit; so does the trace, text, to its own digits."""
        first = self.simulate('--trace', 'first.csv', '--record', 'first.rec')
        again = self.simulate('--device', 'replay:first.rec', '--trace', 'again.csv')
        self.assertEqual((again['device'], again['arm']), ('replay:first.rec', ''))
        self.assertEqual(again['ticks'], first['ticks'] - 1)  # from its first row's time to its last's
        one, two = self.trace('first.csv'), self.trace('again.csv')
        for a, b in zip(one, two):
            self.assertEqual([a[k] for k in ('device_x_m', 'collision_fx_n', 'output_fx_n', 'contacts')],
                             [b[k] for k in ('device_x_m', 'collision_fx_n', 'output_fx_n', 'contacts')])
        self.simulate('--device', 'replay:first.csv', '--trace', 'text.csv')
        for a, b in zip(one, self.trace('text.csv')):
            self.assertAlmostEqual(a['device_x_m'], b['device_x_m'], delta=1e-7)
            self.assertAlmostEqual(a['output_fx_n'], b['output_fx_n'], delta=0.02)
        self.assertGreater(max(row['output_fx_n'] for row in one), 1)

    def test_script(self):
        """Four lines by hand: to the wall and 2 mm past touching it."""
        pathlib.Path(self.path('way.csv')).write_text('t_s,x_m,y_m,z_m\n0,0.075,0.04,0\n0.6,0.075,0.04,0\n0.9,0.053,0.04,0\n1.5,0.053,0.04,0\n', encoding='utf-8')
        told = self.simulate('--device', 'replay:way.csv', '--trace', 'way_out.csv')
        self.assertEqual(told['seconds'], 1.5)
        last = self.trace('way_out.csv')[-1]
        self.assertAlmostEqual(last['device_x_m'], 0.053, delta=1e-6)
        self.assertGreater(last['output_fx_n'], 0.5)
        told = self.simulate('--device', 'replay:way.csv', scene='assets/cup_hold.plan')
        self.assertGreater(told['output_force_peak_n'], 0.5)

    def test_bad_replays(self):
        for text, code, says in [('', 3, 'way.csv'), ('x_m,y_m,z_m\n', 3, 'line 1'), ('t_s,x_m,y_m,z_m\n0,0,0,0\n1,zero,0,0\n', 3, 'line 3'),
                                 ('t_s,x_m,y_m,z_m\n1,0,0,0\n0,0,0,0\n', 3, 'times that do not grow'), ('VXSREC01' + '\x01' * 40, 3, 'as a recording'),
                                 ('t_s,x_m,y_m,z_m\n0,1e300,0,0\n', 3, 'beyond 1e9')]:
            with self.subTest(text):
                pathlib.Path(self.path('way.csv')).write_text(text, encoding='utf-8')
                self.assertIn(says, self.simulate('--device', 'replay:way.csv', code=code))
        self.assertIn('cannot be read', self.simulate('--device', 'replay:none.csv', code=2))
        self.assertIn('say what', self.simulate('--device', 'replay:', code=1))

    # --- hardware, at the end of a pseudo-terminal

    @on_busy_machines
    def test_hardware(self):
        process, name = self.device('push')
        told = self.simulate('--device', name, '--realtime', '--seconds', '2.5')
        self.assertEqual(told['device'], name)
        self.assertGreater(told['contact_ticks'], 100)
        most, last, age = self.end(process)
        self.assertGreater(most, 0.5)
        self.assertLess(most, 8.01)
        self.assertEqual(last, 0)

    def test_unguarded(self):
        process, name = self.device('push')
        for which, guards in GUARDS.items():
            with self.subTest(which):
                scene = json.loads((self.folder / 'cup_hold.scene.json').read_text(encoding='utf-8'))
                scene['guards'] = guards
                (self.folder / 'bare.scene.json').write_text(json.dumps(scene), encoding='utf-8')
                self.run_voxshell('convert', 'bare.scene.json', '-o', 'bare', '-q', '--force')
                for what in ('bare.scene.json', 'bare/bare.plan'):
                    done = self.run_voxshell('simulate', what, '--assets', 'bare', '--device', name, '--realtime', '--seconds', '1', code=4)
                    self.assertIn('without start-inside or without soft-start', done.stderr)
                self.run_voxshell('simulate', 'bare.scene.json', '--assets', 'bare', '--seconds', '0.1')  # on a simulated one it may
        self.assertEqual(self.end(process)[0], 0)  # the motors never moved

    def test_refusals(self):
        process, name = self.device('push')
        self.assertIn('--realtime', self.simulate('--device', name, code=1))
        self.assertIn('no such device', self.simulate('--device', 'hvlink:/dev/there-is-none', '--realtime', code=2))
        self.assertIn('--live', self.simulate('--live', 'x', code=1))
        self.assertEqual(self.end(process)[0], 0)

    def start(self, *arguments):
        run = subprocess.Popen([command.BIN, 'simulate', 'cup_hold.scene.json', '--assets', 'assets', '--realtime', *arguments], cwd=self.folder,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(run.stdout.close)
        self.addCleanup(run.stderr.close)
        self.addCleanup(run.wait)
        self.addCleanup(run.kill)
        return run

    def until_it_pushes(self, run, live):
        """A loop that shows itself in `live` commands 0.6 N, or has ended."""
        deadline, seen = time.time() + 20, None
        while run.poll() is None:
            if time.time() > deadline:
                self.fail(f'the loop does not push: {seen and seen.stdout}')
            seen = subprocess.run([command.BIN, 'device', 'watch', live, '--seconds', '0.1', '--format', 'json'], capture_output=True, text=True, check=False)
            if any(math.hypot(*json.loads(line)['force_n']) > 0.6 for line in seen.stdout.splitlines()):
                break
            time.sleep(0.05)
        time.sleep(0.2)  # and it reaches the motors

    @on_busy_machines
    def test_signals(self):
        """A loop that pushes is ended: the motors are at zero then, and never followed a command for longer than its time to live."""
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 130), (signal.SIGKILL, -signal.SIGKILL)):
            process, name = self.device('push')
            live = self.path(f'live{number}')
            run = self.start('--device', name, '--seconds', '30', '--live', live)
            self.until_it_pushes(run, live)
            run.send_signal(number)
            said = run.communicate(timeout=20)[1]
            self.assertEqual(run.returncode, code, said)
            time.sleep(0.1)
            most, last, age = self.end(process)
            self.assertGreater(most, 0.5)
            self.assertEqual(last, 0)
            self.assertLessEqual(age, 10)

    @on_busy_machines
    def test_asset_cut(self):
        """A file is shortened under a loop that pushes: it goes on with the copy that it checked."""
        process, name = self.device('push')
        live = self.path('live')
        run = self.start('--device', name, '--seconds', '6', '--trace', 'cut.csv', '--force', '--live', live)
        self.until_it_pushes(run, live)
        cut = [file for file in (self.folder / 'assets').iterdir() if file.suffix in ('.voxmap', '.pointshell')]
        self.assertGreater(len(cut), 1)
        for file in cut:
            os.truncate(file, 0)
        was = run.poll()
        said = run.communicate(timeout=60)[1]
        shutil.rmtree(self.folder / 'assets')
        shutil.copytree(self.assets.name, self.folder / 'assets')
        self.assertEqual(run.returncode, 0, said)
        self.assertIsNone(was, 'over before the files were cut')
        most, last, _ = self.end(process)
        self.assertGreater(most, 0.5)
        self.assertEqual(last, 0)
        forces = [max(abs(row[f'output_f{axis}_n']) for axis in 'xyz') for row in self.trace('cut.csv')]
        self.assertGreater(max(forces[-500:]), 0.5)

    @on_busy_machines
    def test_second_process(self):
        process, name = self.device('push')
        run = self.start('--device', name, '--seconds', '30')
        time.sleep(2)
        self.assertIn('in use by another program', self.simulate('--device', name, '--realtime', '--seconds', '1', code=2))
        self.assertIn('in use by another program', self.run_voxshell('device', 'test', name, code=2).stderr)
        was = run.poll()
        run.kill()
        self.assertIsNone(was, run.communicate()[1])
        self.end(process)

    def test_unplugged(self):
        process, name = self.device('push')
        run = self.start('--device', name, '--seconds', '6')
        time.sleep(3)
        process.kill()
        said = run.communicate(timeout=30)[1]
        self.assertEqual(run.returncode, 4, said)
        self.assertRegex(said, r'ended in a fault \(device (GONE, usb|FAULT, watchdog)\)')

    @unittest.skipUnless(os.environ.get('VXS_REAL_TIME'), 'on the wall clock, which a busy machine stops: VXS_REAL_TIME=1; test_calibration has virtual time')
    @on_busy_machines
    def test_calibrate(self):
        """100 g on motors that give half of what they are told: twice as many commanded newtons a true one."""
        process, name = self.device('hang', '0.1', '4.5', '0.5')
        told = json.loads(self.run_voxshell('device', 'calibrate', name, '--mass', '100g', '--period', '0.8', '--format', 'json').stdout)
        self.assertEqual(schema.problems(told, DEVICE), [])
        self.assertAlmostEqual(told['scale'], 2, delta=0.1)
        self.assertAlmostEqual(told['empty_n'], 0.2, delta=0.05)
        self.assertEqual(told['option'], '')
        self.assertEqual(self.end(process)[1], 0)

    def test_calibrate_refusals(self):
        name = 'hvlink:/dev/there-is-none'
        for arguments, code, says in [((name,), 1, '--mass'), ((name, '--mass', '1g'), 2, 'no such device'), (('sim:falcon', '--mass', '100g'), 5, 'no motors'), ((name, '--mass', '0g'), 1, '--mass'),
                                      ((name, '--mass', '3mm'), 1, '--mass')]:
            with self.subTest(arguments):
                self.assertIn(says, self.run_voxshell('device', 'calibrate', *arguments, code=code).stderr)

    # --- looked at from elsewhere

    def test_live(self):
        run = self.start('--device', 'sim:falcon', '--seconds', '30', '--live', self.path('live'))
        deadline = time.time() + 20
        while not os.path.exists(self.path('live')) and time.time() < deadline:
            time.sleep(0.05)
        time.sleep(1.5)
        lines = self.run_voxshell('device', 'watch', self.path('live'), '--seconds', '0.5', '--format', 'json').stdout.splitlines()
        rows = [json.loads(line) for line in lines]
        self.assertGreater(len(rows), 1)
        for row in rows:
            self.assertEqual(schema.problems(row, LIVE), [])
        self.assertGreater(rows[-1]['tick'], rows[0]['tick'])
        self.assertGreater(rows[-1]['force_n'][0], 0.5)  # it presses by then
        self.assertIn('tick', self.run_voxshell('device', 'watch', self.path('live'), '--seconds', '0.2').stdout)
        run.send_signal(signal.SIGINT)
        run.communicate(timeout=20)
        self.assertFalse(os.path.exists(self.path('live')))
        self.assertIn('simulate SCENE --realtime --live', self.run_voxshell('device', 'watch', self.path('live'), code=2).stderr)
        self.run_voxshell('device', 'watch', 'assets/cup_hold.voxmap', code=3)


if __name__ == '__main__':
    command.main()
