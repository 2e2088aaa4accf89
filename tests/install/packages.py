# SPDX-License-Identifier: MIT
"""The Debian packages: what is in them, and that a project in C and one in C++ find and link what was unpacked."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD = pathlib.Path(os.environ['VOXSHELL_BUILD'])
SOURCE = pathlib.Path(os.environ['VOXSHELL_SOURCE'])
ASSET = SOURCE / 'tests/golden/valid/clearance.voxmap'
OWN = {'own_filter': r'^lab-lag: collision 0\.[5-9]\d* N', 'own_effect': r'65\.0 mm: -?0\.\d+ N', 'own_device': r'motor at 0\.000 N after the end'}
NEEDED = ('cpack', 'cmake', 'dpkg-deb', 'dpkg-shlibdeps', 'file', 'pkg-config', 'cc', 'c++')


def run(*command, **more):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False, **more)
    if done.returncode:
        raise AssertionError(f'{" ".join(map(str, command))}: exit {done.returncode}\n{done.stdout}{done.stderr}')
    return done.stdout


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix='voxshell-'))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        for turn in ('first', 'second'):
            run('cpack', '-G', 'DEB', '--config', BUILD / 'CPackConfig.cmake', '-B', cls.folder / turn, '-D', f'CPACK_PACKAGE_DIRECTORY={cls.folder / turn}',
                cwd=BUILD, env={**os.environ, 'SOURCE_DATE_EPOCH': '1700000000'})
        cls.debs = {deb.name.split('_')[0]: deb for deb in sorted((cls.folder / 'first').glob('*.deb'))}
        cls.root = cls.folder / 'root'
        for deb in cls.debs.values():
            run('dpkg-deb', '-x', deb, cls.root)
        cls.lib = next(cls.root.rglob('libvoxshell.a')).parent
        cls.samples = cls.root / 'usr/share/doc/voxshell-doc/samples'  # as they are shipped
        cls.env = {**os.environ, 'LD_LIBRARY_PATH': str(cls.lib), 'PKG_CONFIG_PATH': str(cls.lib / 'pkgconfig')}
        run(cls.root / 'usr/bin/voxshell', 'convert', BUILD / 'samples/cup_hold.scene.json', '-o', cls.folder / 'assets', '-q')
        cls.plan = cls.folder / 'assets/cup_hold.plan'

    def control(self, name):
        return dict(re.findall(r'^([\w-]+): (.*)$', run('dpkg-deb', '-f', self.debs[name]), re.M))

    def test_there_are_five(self):
        self.assertEqual(sorted(self.debs), ['libvoxshell-dev', 'libvoxshell-devices0', 'libvoxshell0', 'voxshell-doc', 'voxshell-tools'])
        version = re.search(r'project\(voxshell VERSION ([\d.]+)', (SOURCE / 'CMakeLists.txt').read_text())[1]
        for name in self.debs:
            control = self.control(name)
            self.assertEqual(control['Version'], version)
            self.assertTrue(control['Description'] and control['Maintainer'])

    def test_the_same_bytes_again(self):
        for deb in self.debs.values():
            self.assertEqual(deb.read_bytes(), (self.folder / 'second' / deb.name).read_bytes(), deb.name)

    def test_dependencies(self):
        names = {name: {d.split()[0] for d in self.control(name).get('Depends', '').split(', ') if d} for name in self.debs}
        self.assertEqual(names['libvoxshell0'], {'libc6'})
        self.assertLessEqual(names['libvoxshell-devices0'], {'libc6', 'libvoxshell0', 'libusb-1.0-0'})
        self.assertIn('libvoxshell0', names['libvoxshell-devices0'])
        self.assertEqual(names['libvoxshell-dev'], {'libvoxshell0', 'libvoxshell-devices0'})
        self.assertFalse(any('voxshell' in d for d in names['voxshell-tools']), 'the program has the runtime in it')
        self.assertIn('libc6', names['voxshell-tools'])
        self.assertEqual(names['voxshell-doc'], set())
        self.assertEqual(self.control('voxshell-doc')['Architecture'], 'all')

    def test_each_file_once_and_each_licence(self):
        seen = {}
        for name, deb in self.debs.items():
            for line in run('dpkg-deb', '-c', deb).splitlines():
                path = line.split()[5]
                if not path.endswith('/'):
                    self.assertNotIn(path, seen, f'in {name} and {seen.get(path)}')
                    seen[path] = name
            text = (self.root / f'usr/share/doc/{name}/copyright').read_text()
            self.assertIn('GNU GENERAL PUBLIC LICENSE' if name == 'voxshell-tools' else 'Permission is hereby granted', text)
        of = lambda path: seen.get('./usr/' + path)
        self.assertEqual(of('bin/voxshell'), 'voxshell-tools')
        self.assertEqual(of('share/bash-completion/completions/voxshell'), 'voxshell-tools')
        self.assertEqual(of('lib/udev/rules.d/70-voxshell.rules'), 'libvoxshell-devices0')
        self.assertEqual(of('include/voxshell/format/container.h'), 'libvoxshell-dev')
        for document in ('README.md', 'samples/README.md', 'formats/voxmap.md', 'runtime/README.md'):
            self.assertEqual(of('share/doc/voxshell-doc/' + document), 'voxshell-doc', document)

    def test_the_libraries(self):
        for library, others in (('libvoxshell', set()), ('libvoxshell-devices', {'libvoxshell.so.0', 'libusb-1.0.so.0'})):
            dynamic = run('readelf', '-d', self.lib / f'{library}.so.0')
            self.assertEqual(re.search(r'SONAME.*\[(.*)\]', dynamic)[1], f'{library}.so.0')
            self.assertLessEqual(set(re.findall(r'NEEDED.*\[(.*)\]', dynamic)) - {'libc.so.6', 'libm.so.6', 'ld-linux-x86-64.so.2', 'ld-linux-aarch64.so.1'}, others)
            self.assertEqual((self.lib / f'{library}.so').resolve(), (self.lib / f'{library}.so.0').resolve())

    def test_headers_name_nothing_private(self):
        headers = [header for header in self.root.glob('usr/include/voxshell/**/*.h')]
        self.assertGreater(len(headers), 20)
        for header in headers:
            self.assertNotRegex(header.read_text(), r'(?i)vxsi', header.name)

    def acts(self, name, program):
        said = run(program, self.plan, env=self.env)
        self.assertRegex(said, OWN[name], name)
        return said

    def feels(self, program):
        self.assertRegex(run(program, ASSET, env=self.env), r'^0\S* voxel 0\.\d+')
        return run('ldd', program, env=self.env)

    def test_found_by_cmake(self):
        build = self.folder / 'by-cmake'
        stl = self.folder / 'ball.stl'
        sys.path.insert(0, str(SOURCE / 'tests/cli'))
        import shapes
        shapes.write_stl(stl, shapes.sphere(10))
        run('cmake', '-S', SOURCE / 'tests/install/consumer', '-B', build, f'-DCMAKE_PREFIX_PATH={self.root}/usr', f'-DASSETS={stl}', '-Wno-dev',
            '-DPROGRAMS=' + ';'.join(str(self.samples / f'{name}/{name}.c') for name in OWN))
        run('cmake', '--build', build)
        for program in ('in_c', 'in_cpp'):
            self.assertIn('libvoxshell.so.0', self.feels(build / program))
            self.assertNotIn('libvoxshell', self.feels(build / (program + '_static')))
        for name in OWN:
            self.assertIn('libvoxshell.so.0', run('ldd', build / name, env=self.env))
            self.assertNotIn('libvoxshell', run('ldd', build / f'{name}_static', env=self.env))
            said = self.acts(name, build / name)
            if name != 'own_device':  # which runs on the wall clock
                self.assertEqual(said, self.acts(name, build / f'{name}_static'))
        self.assertIn('own kinds: as they say', run(build / 'own_in_cpp', env=self.env))
        run('cmake', '--build', build, '--target', 'ball', env={**self.env, 'PATH': f'{self.root}/usr/bin:{os.environ["PATH"]}'})
        self.assertTrue((build / 'assets/ball.voxmap').exists())

    def test_found_by_pkg_config(self):
        for compiler, source, name in (('cc', 'feel.c', 'voxshell-devices'), ('c++', 'feel.cpp', 'voxshell')):
            for static in (False, True):
                program = self.folder / f'{compiler}-{static}'
                flags = run('pkg-config', '--cflags', '--libs', *(['--static'] if static else []), name, env=self.env).split()
                if static:  # the archives, where there is a choice
                    flags = [f'-l:lib{f[2:]}.a' if f.startswith('-lvoxshell') else f for f in flags]
                run(compiler, '-o', program, SOURCE / 'tests/install/consumer' / source, *flags)
                self.assertEqual('libvoxshell.so.0' in self.feels(program), not static)
        flags = run('pkg-config', '--cflags', '--libs', 'voxshell-devices', env=self.env).split()
        for name in OWN:
            run('cc', '-std=c11', '-Wall', '-Werror', '-o', self.folder / name, self.samples / f'{name}/{name}.c', *flags, '-lm')
            self.acts(name, self.folder / name)

    def test_the_program_and_its_pages(self):
        program = self.root / 'usr/bin/voxshell'
        self.assertRegex(run(program, '--version'), r'^voxshell 0\.')
        self.assertIn('ok', run(program, 'verify', ASSET))
        verbs = re.findall(r'^  (\w+) ', run(program, '--help').split('verbs\n')[1].split('options\n')[0], re.M)
        pages = sorted(page.name for page in (self.root / 'usr/share/man/man1').iterdir())
        self.assertEqual(pages, sorted(['voxshell.1', *(f'voxshell-{verb}.1' for verb in verbs)]))


if __name__ == '__main__':
    lacking = [name for name in NEEDED if not shutil.which(name)]
    if lacking or not (BUILD / 'CPackConfig.cmake').exists():
        print(f'packages: skipped: no {", ".join(lacking) or "CPackConfig.cmake"}', file=sys.stderr)
        sys.exit(77)
    unittest.main()
