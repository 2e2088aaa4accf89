# SPDX-License-Identifier: GPL-3.0-or-later
"""Help, version, and requests that are refused before any work begins."""
import command
import shapes

VERBS = ('convert', 'batch', 'inspect', 'verify', 'diff', 'pack', 'export', 'simulate')


class Usage(command.CommandTest):
    def setUp(self):
        super().setUp()
        self.stl = shapes.write_stl(self.path('part.stl'), shapes.box())
        self.glb = shapes.write_glb(self.path('cup.glb'), shapes.cup())

    def test_help_is_one_screen_with_an_example_first(self):
        for arguments in ([], *([verb] for verb in VERBS)):
            done = self.run_voxshell(*arguments, '--help', err='')
            lines = done.stdout.splitlines()
            self.assertTrue(lines[0].startswith(' '.join(['voxshell', *arguments])), lines[0])
            self.assertLess(len(lines), 48, arguments)
            self.assertLess(max(map(len, lines)), 120, arguments)
        self.run_voxshell('-h', out='^voxshell convert')

    def test_what_was_meant(self):
        self.run_voxshell('convert', self.glb, '-o', 'a', '--voxle', '2mm', code=1, out='', err=r'^voxshell convert: error: --voxle is not an option; did you mean --voxel\?\nsee')
        self.run_voxshell('convert', self.glb, '-o', 'a', '--zzzzzz', code=1, out='', err=r'error: --zzzzzz is not an option\nsee')
        self.run_voxshell('inspect', 'one', 'two', code=1, out='', err=r"error: 'two': one argument too many\nsee")
        self.run_voxshell('zzzzzz', code=1, out='', err=r"error: 'zzzzzz' is not a verb\nsee")
        self.run_voxshell('convert', self.folder, '-o', 'a', '--voxel', '2mm', code=2, out='', err=r'is a folder; name the files in it')
        self.run_voxshell('convert', self.path('part.step'), '-o', 'a', '--voxel', '2mm', code=5, out='', err=r"'\.step' is not one of .*; save the part as one of these")
        self.run_voxshell('convert', self.glb, '-o', 'a', '--voxel', '2mm', '-q')
        self.run_voxshell('inspect', 'a/cup', code=2, out='', err=r'a/cup: No such file or directory; did you mean a/cup\.voxmap\?$')
        self.run_voxshell('inspect', 'a', code=2, out='', err=r'a: is a folder, not an asset; did you mean a/cup\.pointshell\?$')
        with open(self.path('room.scene.json'), 'w', encoding='utf-8') as file:
            file.write('{}')
        for verb in ('simulate', 'design'):
            for name in ('room', 'room.scene'):
                self.run_voxshell(verb, *(['-q'] if verb == 'simulate' else []), name, code=5, out='', err=r'did you mean room\.scene\.json\?$')

    def test_every_verb_and_exit_code_is_in_the_help(self):
        text = self.run_voxshell('--help').stdout
        for verb in VERBS:
            self.assertRegex(text, rf'(?m)^  {verb} ')
        for code in ('0 ok', '1 usage', '2 file', '3 invalid', '4 requirement', '5 unsupported', '6 differs', '70 bug', '130 interrupted'):
            self.assertIn(code, text)

    def test_version(self):
        self.run_voxshell('--version', out=r'^voxshell \d+\.\d+\.\d+\n$', err='')
        self.run_voxshell('convert', '--version', out=r'^voxshell \d+\.\d+\.\d+\n$', err='')

    def test_no_or_unknown_verb(self):
        self.run_voxshell(code=1, out='', err=r'^voxshell: error: a verb is missing\nsee voxshell --help\n$')
        self.run_voxshell('convrt', code=1, out='', err=r"^voxshell: error: 'convrt' is not a verb; did you mean convert\?\nsee voxshell --help\n$")
        self.run_voxshell('--convert', code=1, out='', err=r'^voxshell: error: .*\nsee voxshell --help\n$')

    def test_missing_and_unknown_options(self):
        out = self.path('out')
        self.refused(1, 'INPUT', '-o', out, '--voxel', '1mm')
        self.refused(1, '--output', self.glb, '--voxel', '1mm')
        self.refused(1, '--voxel is required', self.glb, '-o', out)
        self.refused(1, '--vixel', self.glb, '-o', out, '--vixel', '1mm')
        self.refused(1, '--format', self.glb, '-o', out, '--voxel', '1mm', '--format', 'xml')
        self.refused(1, '--shell', self.glb, '-o', out, '--voxel', '1mm', '--shell', 'best')
        self.refused(1, '--jobs', self.glb, '-o', out, '--voxel', '1mm', '-j', '-3')
        self.refused(1, '--jobs', self.glb, '-o', out, '--voxel', '1mm', '-j', 'many')

    def test_lengths_carry_a_unit(self):
        for text, why in (('1', 'has no unit; write 1mm'), ('0.5 mm', 'unknown unit'), ('1ft', 'unknown unit'), ('mm', 'not a length'),
                          ('', 'not a length|LEN missing'), ('-1mm', 'out of range|required|--voxel'), ('0mm', 'out of range'), ('nanm', 'not a length'),
                          ('infm', 'not a length'), ('1e400m', 'out of range'), ('1e-400m', 'out of range'),
                          ('1e99999999999mm', 'out of range'), ('0x1mm', 'unknown unit|not a length'), ('1,5mm', 'unknown unit')):
            with self.subTest(text=text):
                self.refused(1, why, self.glb, '-o', self.path('out'), f'--voxel={text}')

    def test_memory_sizes(self):
        for text in ('4X', 'G', '-1G', '1.5G', '99999999999999T', '1K'):
            with self.subTest(text=text):
                self.refused(1, '--max-memory|memory size', self.glb, '-o', self.path('out'), '--voxel', '1mm', f'--max-memory={text}')

    def test_a_unit_is_required_for_stl_alone(self):
        out = self.path('out')
        self.refused(1, r'part\.stl: an STL file has no unit; say --unit mm', self.stl, '-o', out, '--voxel', '1mm')
        self.refused(1, '--unit: only for STL', self.glb, '-o', out, '--voxel', '1mm', '--unit', 'mm')
        self.refused(1, '--unit', self.stl, '-o', out, '--voxel', '1mm', '--unit', 'ft')
        self.run_voxshell('convert', self.stl, self.glb, '-o', out, '--voxel', '2mm', '--unit', 'mm', '-q', err='')

    def test_two_inputs_of_one_name(self):
        self.folder.joinpath('other').mkdir()
        twin = shapes.write_glb(self.path('other', 'part.glb'), shapes.box())
        self.refused(1, r'part\.glb: and .*part\.stl would both write part\.voxmap', self.stl, twin, '-o', self.path('out'),
                     '--voxel', '1mm', '--unit', 'mm')

    def test_unknown_ending(self):
        for name in ('part.step', 'part', 'scene.json'):
            path = self.path(name)
            with open(path, 'wb') as file:
                file.write(b'ISO-10303-21;')
            self.refused(5, rf'{name}: .*ending', path, '-o', self.path('out'), '--voxel', '1mm')

    def test_the_locale_changes_nothing(self):
        one = self.run_voxshell('convert', self.glb, '-o', 'a', '--voxel', '0.5mm', '--format', 'json', '--reproducible').stdout
        for locale in ('de_DE.UTF-8', 'C.UTF-8', 'xx_YY'):
            other = self.run_voxshell('convert', self.glb, '-o', 'a', '--voxel', '0.5mm', '--format', 'json', '--reproducible',
                                      env={'LC_ALL': locale, 'LANG': locale}).stdout
            self.assertEqual(one, other)

    def test_no_colour_where_no_terminal_is(self):
        for env in ({}, {'NO_COLOR': '1'}, {'CLICOLOR_FORCE': '1'}):
            self.assertNotIn('\033', self.run_voxshell('convert', 'none.glb', '-o', 'x', '--voxel', '1mm', code=2, env=env).stderr)


if __name__ == '__main__':
    command.main()
