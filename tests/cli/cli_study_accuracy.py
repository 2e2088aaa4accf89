# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell study accuracy: what study_page.py asks of every study; the reference's bars; the advice; a run that goes on where it was
interrupted, and gives the same files but for times."""
import csv
import os
import pathlib
import signal
import subprocess
import time

import command
import study_page

SCENE = pathlib.Path(os.environ.get('VOXSHELL_BUILD', '.'), 'samples/cup_press.scene.json')


class Accuracy(study_page.StudyTest):
    ARGUMENTS = ('accuracy', SCENE, '--quick', '--voxel', '2mm', '--error', '5%')
    COMMAND = 'voxshell study accuracy cup_press.scene.json -o DIR --quick --voxel 2mm --error 5%'

    def test_reference(self):
        """Halving its pieces changes it by less than 0.2 %; where a formula exists both agree within 0.5 %."""
        rows = self.csv['reference.csv']
        self.assertEqual([row['scene'] for row in rows], ['cup_press', 'ball-on-plane', 'ball-on-cylinder', 'ball-in-bowl'])
        for row in rows:
            self.assertLess(float(row['halved_pct']), 0.2, row)
            if row['scene'] != 'cup_press':
                self.assertLess(float(row['formula_pct']), 0.5, row)
        self.assertEqual(rows[0]['formula_pct'], '')
        holds = {claim['id']: claim['verdict'] for claim in self.told['claims']}
        self.assertEqual((holds['halving'], holds['formula'], holds['culling']), ('holds',) * 3)

    def test_configurations(self):
        """Each valid pair of law and field, with both shells and all weightings; times are there, and in order."""
        rows, times = self.csv['accuracy.csv'], self.csv['accuracy_timing.csv']
        self.assertEqual(len(rows), 2 * 10 * 3)
        self.assertEqual({row['field'] for row in rows if row['law'] == 'gradient'}, {'distance'})
        for row, ns in zip(rows, times):
            self.assertEqual(row['configuration'], ns['configuration'])
            self.assertTrue(0 < float(row['error_pct']) <= 100)
            worst = [float(ns[f'tick_{name}_us']) for name in ('p50', 'p99', 'p999', 'worst', 'max')]
            self.assertEqual(worst, sorted(worst))
            self.assertTrue(0 < worst[0] and 0 < float(ns['conversion_s']))
        # A distance with its gradient is what the reference is made of, as cells get finer: its error is small at two millimetres already.
        best = [float(row['error_pct']) for row in rows if row['law'] == 'gradient' and row['shell'] == 'exact' and row['weighting'] == 'area']
        self.assertLess(best[0], 3)
        worst = [float(row['error_pct']) for row in rows if row['law'] == 'original' and row['field'] == 'surface' and row['shell'] == 'naive']
        self.assertGreater(min(worst), 20)

    def test_readme_picture(self):
        """Its errors are the ones found here, where both have them; its times are those of the machine that drew it."""
        with open(command.SOURCE / 'samples/pictures/error_over_time.csv', encoding='utf-8') as file:
            kept = {tuple(row[name] for name in ('law', 'field', 'shell', 'weighting')): float(row['error_pct']) for row in csv.DictReader(file) if row['voxel_mm'] == '2'}
        self.assertEqual(len(kept), 60)
        for row in self.csv['accuracy.csv']:
            error = float(row['error_pct'])
            self.assertAlmostEqual(kept[row['law'], row['field'], row['shell'], row['weighting']], error, delta=1e-3 * error)
        self.is_in_the_readme('error_over_time')

    def test_advice(self):
        answer = self.told['answers'][0]
        error = answer['numbers'][0]
        self.assertEqual((error['csv'], error['column']), ('accuracy.csv', 'error_pct'))
        self.assertLessEqual(error['value'], 5)
        taken = float(self.csv['accuracy_timing.csv'][error['row'] - 1]['tick_p999_us'])
        for row, ns in zip(self.csv['accuracy.csv'], self.csv['accuracy_timing.csv']):
            self.assertTrue(float(row['error_pct']) > 5 or float(ns['tick_p999_us']) >= taken)
        self.assertIn(answer['question'], self.done.stdout)

    def test_no_bits(self):
        self.assertEqual([row['other_bits'] for row in self.csv['culling.csv']], ['0'] * 8)
        self.assertEqual([row['other_force'] for row in self.csv['static_size.csv'] if row['kind'] == 'copies'], ['0'] * 3)
        self.assertTrue(all(float(row['rms_ppm']) < 1000 for row in self.csv['rounding.csv']))

    def test_filter(self):
        """The delay is the filter's own, the noise grows with the bandwidth."""
        rows = self.csv['filter_bandwidth.csv']
        for n, row in enumerate(rows):
            if float(row['bandwidth_hz']) >= 10:
                self.assertAlmostEqual(float(row['delay_ms']), float(row['delay_ideal_ms']), delta=0.1 * float(row['delay_ideal_ms']))
            if float(row['bandwidth_hz']) > 5:
                self.assertGreaterEqual(float(row['noise_pct']), float(rows[n - 1]['noise_pct']))

    def test_goes_on(self):
        """Interrupted in the middle it keeps what is done, goes on from there, and ends with the same numbers."""
        folder, state = pathlib.Path(self.path('again')), pathlib.Path(self.path('again'), 'accuracy.state')
        run = subprocess.Popen([command.BIN, 'study', *map(str, self.ARGUMENTS), '-o', str(folder), '-j', '1', '-q'], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
        end = time.monotonic() + 300
        while not (state.exists() and state.read_text().count('\nrun ') >= 10):
            self.assertTrue(run.poll() is None and time.monotonic() < end, 'never came to its tenth configuration')
            time.sleep(0.005)
        run.send_signal(signal.SIGINT)
        err = run.communicate(timeout=60)[1]
        self.assertEqual(run.returncode, 130, err)
        self.assertRegex(err, r'^voxshell study: \d+ rows are kept in .*accuracy.state; the same command goes on from there\nvoxshell study: interrupted\n$')
        self.assertEqual(self.listing(folder), ['accuracy.state'])
        kept = [line for line in state.read_text().splitlines() if line.startswith('run ')]
        with state.open('a') as file:
            file.write('run cut off\t1 2')
        # Rows of other options are not taken; here the question alone is another one, which rows do not hang on.
        done = self.run_voxshell('study', *self.ARGUMENTS[:-1], '0.001%', '-o', folder, '-q', code=4, err=r'no configuration that was tried holds that: the fastest takes')
        self.assertRegex(done.stdout, 'None of the configurations tried')
        self.assertFalse(state.exists())
        again = (folder / 'accuracy_timing.csv').read_text()
        for line in kept:
            p50 = 1e-3 * float(line.split('\t')[1].split()[16])
            self.assertIn(f',{p50!r},', again)
        for name in ('accuracy', 'reference', 'steps', 'pairs', 'culling', 'rounding', 'filter_bandwidth', 'points', 'static_size', 'error_over_bytes', 'error_over_voxel'):
            self.assertEqual((folder / f'{name}.csv').read_bytes(), (self.study / f'{name}.csv').read_bytes(), name)

    def test_refusals(self):
        self.refused(1, r'needs a SCENE', 'accuracy', '-o', 'study', verb='study')
        self.refused(1, r'ball-on-plane', 'accuracy', 'cup.glb', '-o', 'study', verb='study')
        self.refused(2, r'nowhere.scene.json', 'accuracy', 'nowhere.scene.json', '-o', 'study', verb='study')
        self.refused(1, r'--budget', 'accuracy', SCENE, '-o', 'study', '--budget', '2', verb='study')
        self.refused(1, r'--error', 'accuracy', SCENE, '-o', 'study', '--error', '0.01', verb='study')
        self.refused(1, r'unit', 'accuracy', SCENE, '-o', 'study', '--voxel', '2', verb='study')
        text = SCENE.read_text().replace('47mm', '70mm')
        for name in ('cup.glb', 'sphere.glb'):
            pathlib.Path(self.path(name)).write_bytes((SCENE.parent / name).read_bytes())
        pathlib.Path(self.path('far.scene.json')).write_text(text)
        self.refused(3, r'far.scene.json: the hand\'s path touches nothing', 'accuracy', 'far.scene.json', '-o', 'study', verb='study')
        (self.folder / 'study').mkdir()
        (self.folder / 'study/index.html').write_text('mine')
        self.refused(2, r'index.html: exists', 'accuracy', SCENE, '-o', 'study', verb='study')


if __name__ == '__main__':
    command.main()
