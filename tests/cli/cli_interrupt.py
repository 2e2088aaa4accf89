# SPDX-License-Identifier: GPL-3.0-or-later
"""^C and kill in the middle of work: an exit code, an empty folder, and a next run that completes."""
import os
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
