# SPDX-License-Identifier: GPL-3.0-or-later
"""^C and kill in the middle of work: an exit code, an empty folder, and a next run that completes."""
import json
import os
import shutil
import signal
import subprocess
import time

import command
import shapes


class Interrupt(command.CommandTest):
    def start(self, voxel):
        glb = shapes.write_glb(self.path('cup.glb'), shapes.cup(radius=60, height=90, wall=3, segments=200))
        return subprocess.Popen([command.BIN, 'convert', glb, '-o', self.path('out'), '--voxel', voxel, '-j2', '--progress', 'json'],
                                stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def test_interrupted_in_every_stage(self):
        stages = set()
        for delay in (0.02, 0.3, 0.8, 1.5, 2.5):
            for kind in (signal.SIGINT, signal.SIGTERM):
                process = self.start('0.12mm')
                time.sleep(delay)
                process.send_signal(kind)
                sent = time.monotonic()
                out, err = process.communicate(timeout=60)
                if process.returncode == 0:
                    self.skipTest('this machine is too quick to be interrupted')
                lines = err.splitlines()
                if process.returncode == -kind:
                    continue  # before the program had begun
                self.assertEqual((process.returncode, out, lines[-1]), (130, '', 'voxshell convert: interrupted'), err)
                self.assertLess(time.monotonic() - sent, 20)
                self.assertFalse(os.path.exists(self.path('out')))
                stages.update(line for line in lines[:-1] if '"done":0,' in line)
        self.assertGreater(len(stages), 1)

    def test_little_work_after_the_request(self):
        """From SIGINT to the process's end, giving back its memory included: 100 ms of work, whatever else the machine does.
        VXS_CANCEL_VOXEL=0.12mm: a thousand cells, by hand."""
        glb = shapes.write_glb(self.path('fine.glb'), shapes.cup(radius=60, height=90, wall=3, segments=200))
        arguments = [command.BIN, 'convert', glb, '-o', self.path('fine'), '--voxel', os.environ.get('VXS_CANCEL_VOXEL', '0.7mm'), '--channels', 'layers:3,distance:3', '-j2',
                     '--progress', 'json']
        whole = subprocess.run(arguments, capture_output=True, text=True, timeout=120)
        stages = [json.loads(line)['stage'] for line in whole.stderr.splitlines() if '"done":0,' in line]
        self.assertIn('write', stages)
        shutil.rmtree(self.path('fine'))
        worst = {}
        for stage in dict.fromkeys(stages):
            for after in (0.0, 0.1) if 'VXS_CANCEL_VOXEL' not in os.environ else (0.0, 0.3, 1.0, 2.0, 3.0, 4.0):  # seconds of work in the stage
                process = subprocess.Popen(arguments, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
                for line in process.stderr:
                    if json.loads(line)['stage'] == stage:
                        break
                clock = ~process.pid << 3 | 2  # the process's own, all threads (clock_getcpuclockid(3))
                begin = before = time.clock_gettime(clock)
                while before - begin < after and not os.path.exists(self.path('fine', 'fine.vdb')):
                    time.sleep(0.001)
                    before = time.clock_gettime(clock)
                process.send_signal(signal.SIGINT)
                _, status, usage = os.wait4(process.pid, 0)
                process.returncode = os.waitstatus_to_exitcode(status)
                process.stderr.close()
                if process.returncode == 0:  # done before it came
                    shutil.rmtree(self.path('fine'))
                    continue
                self.assertEqual(process.returncode, 130)
                self.assertFalse(os.path.exists(self.path('fine')))
                worst[stage] = max(worst.get(stage, 0), usage.ru_utime + usage.ru_stime - before)
        print('ms of work after the request:', {stage: round(1e3 * work) for stage, work in worst.items()})
        self.assertIn('write', worst)
        for stage, work in worst.items():
            self.assertLess(work, 0.1 * (4 if command.counting() else 1), stage)

    def test_killed_then_run_again(self):
        process = self.start('0.3mm')
        time.sleep(0.4)
        process.kill()
        process.communicate()
        final = [name for name in os.listdir(self.path('out')) if not name.startswith('.')] if os.path.exists(self.path('out')) else []
        self.run_voxshell('convert', 'cup.glb', '-o', 'whole', '--voxel', '0.3mm', '-q')
        for name in final:  # a name that is there is there whole
            with open(self.path('out', name), 'rb') as one, open(self.path('whole', name), 'rb') as other:
                self.assertEqual(one.read(), other.read())
        self.run_voxshell('convert', 'cup.glb', '-o', 'out', '--voxel', '0.3mm', '-q')


if __name__ == '__main__':
    command.main()
