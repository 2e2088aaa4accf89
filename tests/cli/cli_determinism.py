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


if __name__ == '__main__':
    command.main()
