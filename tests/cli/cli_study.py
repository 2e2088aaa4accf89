# SPDX-License-Identifier: GPL-3.0-or-later
"""voxshell study: every number of its page is traced to a row of a CSV, the page needs no other file, and a second run gives the
same files. In a browser too, where chromium is installed. One seed; twice with VXS_STUDY_TWICE=1."""
import base64
import csv
import html.parser
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree

import command
import schema

STUDY = schema.load(command.SOURCE / 'formats/schema/study.schema.json')
TIMES = {'timing.csv'}


class Page(html.parser.HTMLParser):
    """Ids, links, pictures, and the text of each element that says where its number is from."""
    VOID = {'meta', 'link', 'img', 'br'}

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.sources, self.numbers, self.open, self.sortable, self.text = [], [], [], [], [], 0, ''
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        known = dict(attributes)
        if 'id' in known:
            self.ids.append(known['id'])
        if 'href' in known:
            self.links.append(known['href'])
        if 'src' in known:
            self.sources.append((tag, known['src'], known.get('alt', '')))
        if 'data-csv' in known:
            self.numbers.append([known['data-csv'], ''])
        self.sortable += tag == 'table' and 'sortable' in known.get('class', '')
        if tag not in self.VOID:
            self.open.append((tag, 'data-csv' in known))

    def handle_endtag(self, tag):
        assert self.open and self.open[-1][0] == tag, f'</{tag}> closes {self.open[-1:]}'
        self.open.pop()

    def handle_data(self, data):
        self.text += data
        if self.open and self.open[-1][1]:
            self.numbers[-1][1] += data


@unittest.skipUnless(shutil.which('gnuplot'), 'gnuplot is not installed')
class Paper(command.CommandTest):
    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.mkdtemp(prefix='voxshell-')
        cls.addClassCleanup(shutil.rmtree, cls.kept, ignore_errors=True)
        cls.study = pathlib.Path(cls.kept, 'study')
        cls.done = cls.make(cls.study)
        assert cls.done.returncode == 0, cls.done.stderr
        cls.told = json.loads((cls.study / 'summary.json').read_text())
        cls.page = Page((cls.study / 'index.html').read_text())
        cls.csv = {path.name: list(csv.DictReader(path.read_text().splitlines())) for path in cls.study.glob('*.csv')}

    @staticmethod
    def make(folder, *more):
        return subprocess.run([command.BIN, 'study', 'paper', '-o', str(folder), '--quick', '--seeds', '1', '-q', *more], capture_output=True, text=True, timeout=600)

    def cell(self, name, row, column):
        return self.csv[name][row - 1][column]

    def test_summary(self):
        self.assertEqual(schema.problems(self.told, STUDY), [])
        self.assertEqual(self.told['command'], 'voxshell study paper -o DIR --quick --seeds 1')
        for table in self.told['tables']:
            names = [column['name'] for column in table['columns']]
            rows = self.csv[table['csv']]
            self.assertEqual(len(rows), len(table['rows']), table['id'])
            for line, row in zip(rows, table['rows']):
                self.assertEqual(list(line), names)
                for text, value in zip(line.values(), row):
                    self.assertEqual(text if isinstance(value, str) else None if text == '' else float(text), value, table['id'])
        for claim in self.told['claims']:
            self.assertEqual(claim['measured'].count('@'), len(claim['numbers']), claim['id'])
            for number in claim['numbers']:
                text = self.cell(number['csv'], number['row'], number['column'])
                self.assertEqual(None if text == '' else float(text), number['value'], claim['id'])
        for figure in self.told['figures']:
            self.assertTrue((self.study / figure['png']).read_bytes().startswith(b'\x89PNG'))
            svg = (self.study / figure['svg']).read_text()
            self.assertIn(self.told['command'], svg)
            self.assertGreater(len(self.csv[figure['csv']]), 5)

    def test_scenarios(self):
        ran = {row['scenario'] for name in ('runs.csv', 'loop_runs.csv') for row in self.csv[name]}
        self.assertEqual(ran, {f'fig8{c}' for c in 'abcd'} | {'fig9a', 'fig9b', 'degenerate-a', 'degenerate-b', 'control8', 'control9', 'control9-turned', 'wedge', 'peg', 'fig11', 'wall'}
                         | {f'fig12{c}' for c in 'abcd'})
        for row in self.csv['runs.csv']:
            if row['scenario'].startswith('degenerate'):
                self.assertEqual(row['degenerate'], '1')
            elif row['scenario'] not in ('peg', 'fig8a', 'fig8b'):
                self.assertEqual(row['degenerate'], '0', row)
        # What the runtime's own tests pin: the gradient of a trilinear distance has next to no force across a turned plane.
        smooth = [row for row in self.csv['control_means.csv'] if row['scenario'] == 'control8' and row['law'] == 'gradient']
        self.assertTrue(smooth and all(float(row['across_rms_pct']) < 0.5 and float(row['ripple_pct']) < 5 for row in smooth))
        for name in ('fig8', 'fig9'):
            for row in self.csv[f'{name}_means.csv']:
                if row['across_peak_pct']:
                    self.assertGreaterEqual(float(row['across_peak_pct']), float(row['across_rms_pct']))

    def test_page(self):
        self.assertEqual(self.page.open, [])
        self.assertEqual(len(self.page.ids), len(set(self.page.ids)))
        for link in self.page.links:
            self.assertTrue(link == 'data:,' or link.startswith('#') and link[1:] in self.page.ids, link)
        self.assertEqual(len(self.page.sources), len(self.told['figures']))
        for (tag, source, alt), figure in zip(self.page.sources, self.told['figures']):
            self.assertEqual((tag, alt), ('img', figure['title']))
            kind, data = source.split(',', 1)
            self.assertEqual(kind, 'data:image/svg+xml;base64')
            svg = base64.b64decode(data, validate=True)
            self.assertEqual(svg, (self.study / figure['svg']).read_bytes())
            self.assertTrue(xml.etree.ElementTree.fromstring(svg).tag.endswith('svg'))
        text = (self.study / 'index.html').read_text()
        self.assertNotIn('http', text)
        self.assertGreater(self.page.sortable, 8)
        # What does not hold comes first.
        self.assertLess(text.index('id="fails"'), text.index('id="claims"'))
        self.assertLess(text.index('id="claims"'), text.index('id="figure-'))
        for claim in self.told['claims']:
            self.assertIn(f'claim-{claim["id"]}', self.page.ids)
        self.assertEqual(text.count('<code>' + self.told['command'] + '</code>'), 1 + len(self.told['figures']))

    def test_numbers_are_traced(self):
        self.assertGreater(len(self.page.numbers), 500)
        for where, shown in self.page.numbers:
            name, row, column = where.split(':')
            text = self.cell(name, int(row), column)
            if text == '':
                self.assertIn(shown, ('', 'none'), where)
                continue
            digits = len(shown.split('.')[1]) if '.' in shown and 'e' not in shown else 0
            self.assertAlmostEqual(float(shown), float(text), delta=max(0.006 * abs(float(text)), 0.51 * 10.0 ** -digits if digits else 0), msg=where)

    def test_same_again(self):
        if os.environ.get('VXS_STUDY_TWICE') != '1':
            self.skipTest('VXS_STUDY_TWICE=1 runs it twice')
        self.assertEqual(self.make(self.path('again'), '-j', '1').returncode, 0)
        first, second = self.digests(self.study), self.digests(self.path('again'))
        self.assertEqual({k: v for k, v in first.items() if k not in TIMES}, {k: v for k, v in second.items() if k not in TIMES})

    def test_browser(self):
        browser = shutil.which('chromium') or shutil.which('chromium-browser') or shutil.which('google-chrome')
        if not browser:
            self.skipTest('chromium is not installed')
        # Clicks each head twice and tells what is seen, in the page's own title.
        probe = '''<script>addEventListener('load', () => { const bad = [...document.images].filter(i => !i.naturalWidth).length; let sorted = 0;
          for (const table of document.querySelectorAll('table.sortable')) { const heads = table.querySelectorAll('th'), last = heads[heads.length - 1];
            const before = table.tBodies[0].rows.length; last.click(); last.click(); sorted += last.getAttribute('aria-sort') === 'descending' && before === table.tBodies[0].rows.length; }
          document.title = `images ${document.images.length - bad} tables ${sorted} errors ${window.seen}`; });</script>'''
        text = (self.study / 'index.html').read_text()
        text = text.replace('<head>', '<head><script>window.seen = 0; addEventListener("error", () => ++window.seen);</script>', 1).replace('</body>', probe + '</body>', 1)
        pathlib.Path(self.path('probe.html')).write_text(text)
        seen = subprocess.run([browser, '--headless', '--no-sandbox', '--disable-gpu', '--virtual-time-budget=20000', '--dump-dom', f'file://{self.path("probe.html")}'],
                              capture_output=True, text=True, timeout=120).stdout
        self.assertIn(f'<title>images {len(self.page.sources)} tables {self.page.sortable} errors 0</title>', seen)

    def test_text(self):
        lines = self.done.stdout.splitlines()
        order = [line[:14].strip() for line in lines[:-1]]
        self.assertEqual(len(order), len(self.told['claims']))
        self.assertEqual(order, sorted(order, key=['does not hold', 'holds in part', 'holds'].index))
        self.assertTrue(lines[-1].endswith('index.html'))

    def test_refusals(self):
        self.refused(1, r'KIND', verb='study')
        self.refused(1, r'papers', 'papers', '-o', 'study', verb='study')
        self.refused(1, r'--seeds', 'paper', '-o', 'study', '--seeds', '0', verb='study')
        self.refused(2, r'gnuplot is not installed', 'paper', '-o', 'study', verb='study', env={'PATH': '/nonexistent'})


if __name__ == '__main__':
    command.main()
