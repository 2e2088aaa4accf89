# SPDX-License-Identifier: GPL-3.0-or-later
"""The same bytes for any number of threads, any run, any folder: assets and --reproducible report."""
import os
import shutil

import command
import shapes


class Determinism(command.CommandTest):
    def test_same_bytes(self):
        parts = [shapes.write_stl(self.path('ball.stl'), shapes.sphere(10, rings=40)),
                 shapes.write_glb(self.path('cup.glb'), shapes.cup()),
                 shapes.write_stl(self.path('sheet.stl'), shapes.box()[:7])]
        other = self.folder / 'some where' / 'else'
        other.mkdir(parents=True)
        moved = [shutil.copy(part, other) for part in parts]

        def run(name, inputs, *more, env=None):
            self.run_voxshell('convert', *inputs, '-o', name, '--unit', 'mm', '--voxel', '0.25mm', '--reproducible',
                              '--report', f'{name}/report.json', '-q', *more, env=env)
            return self.digests(self.path(name))

        first = run('first', parts, '-j1')
        self.assertEqual(len(first), 10)
        self.assertEqual(run('second', parts, '-j1'), first)
        self.assertEqual(run('threads', parts, '-j2'), first)
        self.assertEqual(run('many', parts, '-j', '7'), first)
        self.assertEqual(run('moved', moved), first)
        self.assertEqual(run('poisoned', parts, env={'MALLOC_PERTURB_': '165', 'TZ': 'Asia/Tokyo', 'HOME': '/nonexistent'}), first)
        text = self.folder.joinpath('first', 'report.json').read_text(encoding='utf-8')
        for word in ('cost', os.path.basename(self.folder), '/'):
            self.assertNotIn(word, text.replace('voxshell-report/1', ''))

    def test_any_schedule(self):
        """Threads that take turns in another way each time: the same bytes. VXS_SCHEDULES: how many ways."""
        shim = command.shim('random_schedule.c', self.folder)
        parts = [shapes.write_stl(self.path('ball.stl'), shapes.sphere(10, rings=40)),
                 shapes.write_glb(self.path('cup.glb'), shapes.cup())]
        found = set()
        for schedule in range(int(os.environ.get('VXS_SCHEDULES', '4'))):
            env = {'LD_PRELOAD': shim, 'VXS_SCHEDULE': str(schedule)} if schedule else {}
            out = f'out{schedule}'
            self.run_voxshell('convert', *parts, '-o', out, '--unit', 'mm', '--voxel', '0.5mm', '--channels', 'layers:3,distance:3',
                              '-q', '-j', str(1 + schedule % 7), env=env)
            self.run_voxshell('batch', *parts, '-o', out + '/batch', '--unit', 'mm', '--voxel', '0.5mm', '-q',
                              '-j', str(1 + schedule % 7), env=env)
            digests = {name: digest for name, digest in self.digests(self.path(out)).items()
                       if name.endswith(('.voxmap', '.pointshell', '.vdb'))}
            self.assertGreaterEqual(len(digests), 4)
            found.add(str(sorted(digests.items())))
        self.assertEqual(len(found), 1)


if __name__ == '__main__':
    command.main()
