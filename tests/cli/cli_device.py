# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell device: what it says of kinds, limits and the loop; a device at the end of a pseudo-terminal; exit codes."""
import json
import os
import pathlib
import signal
import socket
import subprocess
import tempfile
import time
import unittest

import command
import schema

DEVICE = schema.load(command.SOURCE / 'formats/schema/device.schema.json')


class Device(command.CommandTest):
    def told(self, *arguments, code=0):
        told = json.loads(self.run_voxshell('device', *arguments, '--format', 'json', code=code).stdout)
        self.assertEqual(schema.problems(told, DEVICE), [])
        return told

    def test_list(self):
        told = self.told('list')
        self.assertEqual([k['name'] for k in told['kinds']], ['sim', 'hvlink', 'haply', 'spacemouse', 'falcon'])
        for kind in told['kinds']:
            self.assertEqual(kind['built'], kind['lacks'] == '')
            self.assertEqual(kind['verified'], kind['name'] == 'sim')
        where = [d['where'] for d in told['devices']]
        self.assertIn('sim:omega-3', where)
        self.assertIn('sim:dlr-lwr', where)
        text = self.run_voxshell('device', 'list').stdout
        self.assertIn('not verified on hardware', text)

    def test_doctor(self):
        shell = ['--seconds', '0.2', '--rate', '500', '--histogram', 'h.csv', '--plot', 'h.svg']
        result = subprocess.run([command.BIN, 'device', 'doctor', *shell, '--format', 'json'], cwd=self.folder, capture_output=True, text=True)
        self.assertIn(result.returncode, (0, 4))  # a device without permission here is trouble
        told = json.loads(result.stdout)
        self.assertEqual(schema.problems(told, DEVICE), [])
        self.assertEqual(result.returncode == 4, any(f['verdict'] == 'trouble' for f in told['findings']))
        what = [f['what'] for f in told['findings']]
        for one in ('priority', 'memory', 'kernel'):
            self.assertIn(one, what)
        self.assertEqual(told['loop']['ticks'], 100)
        rows = [line.split(',') for line in (self.folder / 'h.csv').read_text().splitlines()]
        self.assertEqual(rows[0], ['from_us', 'late', 'work'])
        self.assertEqual(sum(int(r[1]) for r in rows[1:]), 100)
        self.assertEqual(sum(int(r[2]) for r in rows[1:]), 100)
        self.assertIn('<svg', (self.folder / 'h.svg').read_text())

    def test_simulated(self):
        told = self.told('test', 'sim:omega-3', '--seconds', '0.1')
        self.assertEqual((told['state'], told['loop']['ticks'], told['verified']), ('READY', 100, True))
        self.assertAlmostEqual(told['measurements_hz'], 1000)

    def test_interrupted(self):
        with subprocess.Popen([command.BIN, 'device', 'test', 'sim:falcon', '--seconds', '60'], cwd=self.folder, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True) as run:
            time.sleep(2)
            run.send_signal(signal.SIGINT)
            run.communicate(timeout=10)
            self.assertEqual(run.returncode, 130)

    def test_locked_mouse(self):
        """A six-axis mouse in a tree that umockdev shows as /sys and /dev: found; nobody may read its node, and is told which rule to write."""
        preload = 'libumockdev-preload.so.0'
        probe = subprocess.run(['true'], env={'LD_PRELOAD': preload}, capture_output=True, text=True)
        if os.getuid() != 0 or preload in probe.stderr:
            self.skipTest('needs root and umockdev')
        with tempfile.TemporaryDirectory() as name, socket.socket(socket.AF_UNIX) as calls:
            tree = pathlib.Path(name)
            tree.chmod(0o755)
            for path, text in [('sys/class/hidraw/hidraw0/device/uevent', 'HID_ID=0003:0000256F:0000C635\n'), ('dev/hidraw0', ''), ('ioctl/dev/.keep', '')]:
                (tree / path).parent.mkdir(parents=True, exist_ok=True)
                (tree / path).write_text(text)
            (tree / 'dev/hidraw0').chmod(0o600)
            calls.bind(str(tree / 'ioctl/dev/hidraw0'))
            calls.listen(32)
            (tree / 'ioctl/dev/hidraw0').chmod(0o666)
            for user, usable in [(0, True), (65534, False)]:
                done = subprocess.run([command.BIN, 'device', 'list', '--format', 'json'], user=user, cwd='/', capture_output=True, text=True,
                                      env={**os.environ, 'UMOCKDEV_DIR': str(tree), 'LD_PRELOAD': preload, 'ASAN_OPTIONS': 'verify_asan_link_order=0'})
                self.assertEqual(done.returncode, 0, done.stderr)
                mouse = [d for d in json.loads(done.stdout)['devices'] if d['kind'] == 'spacemouse']
                self.assertEqual([(d['node'], d['where'], d['usable']) for d in mouse], [('/dev/hidraw0', 'hidraw 256f:c635 at /dev/hidraw0', usable)])
                rule = 'write SUBSYSTEM=="hidraw", KERNELS=="*:256F:C635.*", TAG+="uaccess" to /etc/udev/rules.d/70-voxshell.rules'
                self.assertEqual(rule in mouse[0]['why_not'], not usable)

    def test_refusals(self):
        for arguments, code, says in [(['test'], 1, 'say which'), (['test', 'sim:toaster'], 1, "no device 'sim:toaster'; there are sim:touch"), (['test', 'toaster'], 1, 'no such kind'),
                                      (['test', 'hvlink'], 1, 'say where'), (['test', 'haply'], 1, 'haply:VVVV:PPPP over libusb'),
                                      (['test', 'haply:1234:5678'], 2, 'no such device'), (['test', 'haply:/dev/null', '--haply-setup', '4'], 1, '4'),
                                      (['test', 'haply:/dev/null', '--haply-links', '50mm,70mm'], 1, 'haply-links'),
                                      (['test', 'haply:/dev/null', '--haply-links', '50mm,70mm,20'], 1, '20'), (['test', 'hvlink:/dev/there-is-none'], 2, 'no such device'),
                                      (['test', 'hvlink:/dev/null'], 2, 'no such device'), (['dance'], 1, 'dance'),
                                      (['doctor', '--plot', 'h.txt'], 1, 'h.txt'), (['test', 'sim:falcon', '--rate', '99'], 1, '99')]:
            with self.subTest(arguments):
                result = self.run_voxshell('device', *arguments, code=code)
                self.assertIn(says, result.stderr)


if __name__ == '__main__':
    command.main()
