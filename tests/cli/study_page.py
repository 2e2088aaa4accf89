# SPDX-License-Identifier: GPL-3.0-or-later
"""What every study keeps: summary.json is what its schema says and what the CSV have, every number of the page is traced to a row of a CSV,
the page needs no other file, shows its pictures and sorts its tables in a browser, and a second run gives the same files."""
import base64
import csv
import html.parser
import json
import math
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree

import browser
import command
import schema

STUDY = schema.load(command.SOURCE / 'formats/schema/study.schema.json')
PHONE, DESK = (390, 844), (1280, 900)


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


def number(text):
    try:
        return float(text)
    except ValueError:
        return math.nan


class StudyTest(command.CommandTest):
    """A study names its ARGUMENTS and what the page calls its COMMAND; TIMES are files that differ from run to run."""
    ARGUMENTS, COMMAND, TIMES, NUMBERS, TABLES = (), '', set(), 500, 8

    @classmethod
    def setUpClass(cls):
        if not cls.ARGUMENTS:
            raise unittest.SkipTest('no study')
        if not shutil.which('gnuplot'):
            raise unittest.SkipTest('gnuplot is not installed')
        cls.kept = tempfile.mkdtemp(prefix='voxshell-')
        cls.addClassCleanup(shutil.rmtree, cls.kept, ignore_errors=True)
        cls.study = pathlib.Path(cls.kept, 'study')
        cls.done = cls.make(cls.study)
        assert cls.done.returncode == 0, cls.done.stderr
        cls.told = json.loads((cls.study / 'summary.json').read_text())
        cls.page = Page((cls.study / 'index.html').read_text())
        cls.csv = {path.name: list(csv.DictReader(path.read_text().splitlines())) for path in cls.study.glob('*.csv')}

    @classmethod
    def make(cls, folder, *more):
        return subprocess.run([command.BIN, 'study', *map(str, cls.ARGUMENTS), '-o', str(folder), '-q', *more], capture_output=True, text=True, timeout=600)

    def cell(self, name, row, column):
        return self.csv[name][row - 1][column]

    def drawn(self):
        return [figure for figure in self.told['figures'] if 'absent' not in figure]

    def test_summary(self):
        self.assertEqual(schema.problems(self.told, STUDY), [])
        self.assertEqual(self.told['command'], self.COMMAND)
        for table in self.told['tables']:
            for n, column in enumerate(table['columns']):
                rows = self.csv[column.get('csv', table['csv'])]
                self.assertEqual(len(rows), len(table['rows']), table['id'])
                for line, row in zip(rows, table['rows']):
                    text, value = line[column['name']], row[n]
                    self.assertEqual(text if isinstance(value, str) else None if text == '' else float(text), value, table['id'])
            self.assertEqual(list(self.csv[table['csv']][0]), [column['name'] for column in table['columns'] if column.get('csv', table['csv']) == table['csv']])
        for claim in self.told['claims'] + [{**answer, 'measured': answer['answer']} for answer in self.told.get('answers', [])]:
            self.assertEqual(claim['measured'].count('@'), len(claim['numbers']), claim['id'])
            for found in claim['numbers']:
                text = self.cell(found['csv'], found['row'], found['column'])
                self.assertEqual(None if text == '' else float(text), found['value'], claim['id'])
        for figure in self.told['figures']:
            self.assertEqual('svg' in figure and 'png' in figure, 'absent' not in figure)
            if 'absent' in figure:
                self.assertEqual(self.csv[figure['csv']], [{'absent': figure['absent']}])
                self.assertIn(figure['absent'], self.page.text)
                continue
            self.assertTrue((self.study / figure['png']).read_bytes().startswith(b'\x89PNG'))
            svg = (self.study / figure['svg']).read_text()
            self.assertIn(self.told['command'], svg)
            self.assertGreater(len(self.csv[figure['csv']]), 5)

    def test_page(self):
        self.assertEqual(self.page.open, [])
        self.assertEqual(len(self.page.ids), len(set(self.page.ids)))
        for link in self.page.links:
            self.assertTrue(link == 'data:,' or link.startswith('#') and link[1:] in self.page.ids, link)
        drawn = self.drawn()
        self.assertEqual(len(self.page.sources), len(drawn))
        for (tag, source, alt), figure in zip(self.page.sources, drawn):
            self.assertEqual((tag, alt), ('img', figure['title']))
            kind, data = source.split(',', 1)
            self.assertEqual(kind, 'data:image/svg+xml;base64')
            svg = base64.b64decode(data, validate=True)
            self.assertEqual(svg, (self.study / figure['svg']).read_bytes())
            self.assertTrue(xml.etree.ElementTree.fromstring(svg).tag.endswith('svg'))
        text = (self.study / 'index.html').read_text()
        self.assertNotIn('http', text)
        self.assertGreater(self.page.sortable, self.TABLES)
        # What does not hold comes first.
        self.assertLess(text.index('id="fails"'), text.index('id="claims"'))
        self.assertLess(text.index('id="claims"'), text.index('id="figure-'))
        for claim in self.told['claims']:
            self.assertIn(f'claim-{claim["id"]}', self.page.ids)
        self.assertEqual(text.count('<code>' + self.told['command'] + '</code>'), 1 + len(drawn))

    def test_numbers_are_traced(self):
        self.assertGreater(len(self.page.numbers), self.NUMBERS)
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
        self.same_but_times(self.path('again'))

    def times(self):
        """Files that are not the same on every run; where the page shows a time it is one of them."""
        timed = {column['csv'] for table in self.told['tables'] for column in table['columns'] if 'csv' in column}
        timed |= {figure[kind] for figure in self.drawn() if figure.get('timed') for kind in ('csv', 'svg', 'png')}
        return self.TIMES | timed | ({'summary.json', 'index.html'} if timed else set())

    def same_but_times(self, folder):
        first, second = self.digests(self.study), self.digests(folder)
        self.assertEqual(set(first), set(second))
        self.assertEqual({k: v for k, v in first.items() if k not in self.times()}, {k: v for k, v in second.items() if k not in self.times()})

    def test_text(self):
        lines = self.done.stdout.splitlines()
        self.assertEqual(len(lines), len(self.told['claims']) + len(self.told.get('answers', [])) + 1)
        order = [line[:14].strip() for line in lines[:len(self.told['claims'])]]
        self.assertEqual(order, sorted(order, key=['does not hold', 'holds in part', 'holds'].index))
        self.assertTrue(lines[-1].endswith('index.html'))

    def test_browser(self):
        """VXS_BROWSER_SHOTS=DIR keeps what is seen."""
        program = browser.find()
        if not program:
            self.skipTest('chromium is not installed')
        shots = os.environ.get('VXS_BROWSER_SHOTS')
        with browser.Browser(program) as seen:
            for name, (width, height) in (('phone', PHONE), ('desk', DESK)):
                seen.open(self.study / 'index.html', width, height)
                self.pictures_are_seen(seen, width)
                self.assertLessEqual(seen.run('document.documentElement.scrollWidth'), width, 'the page scrolls sideways')
                if shots:
                    seen.screenshot(pathlib.Path(shots, f'{self.told["study"]}-{name}.png'))
            self.tables_sort(seen)
            seen.ask('Emulation.setEmulatedMedia', media='print')
            self.pictures_are_seen(seen, DESK[0])
            paper = seen.pdf()
            self.assertTrue(paper.startswith(b'%PDF') and len(paper) > 50_000, len(paper))
            if shots:
                pathlib.Path(shots, f'{self.told["study"]}.pdf').write_bytes(paper)
            self.assertEqual(seen.errors, [])

    def picture_is(self, figure):
        """samples/pictures/ has what this study draws: its numbers to a thousandth, whatever draws them."""
        with open(command.SOURCE / f'samples/pictures/{figure}.csv', encoding='utf-8') as file:
            kept = list(csv.DictReader(file))
        found = self.csv[f'{figure}.csv']
        self.assertEqual(len(kept), len(found))
        scale = {name: max((abs(number(row[name])) for row in kept if not math.isnan(number(row[name]))), default=0) for name in kept[0]}
        for shown, row in zip(kept, found):
            self.assertEqual(list(shown), list(row))
            for name, text in shown.items():
                if math.isnan(number(text)):
                    self.assertEqual(text, row[name])
                else:
                    self.assertAlmostEqual(number(text), number(row[name]), delta=1e-3 * scale[name], msg=(figure, name))
        self.is_in_the_readme(figure)

    def is_in_the_readme(self, figure):
        picture = command.SOURCE / f'samples/pictures/{figure}.svg'
        self.assertLess(picture.stat().st_size, 100_000)
        self.assertIn(picture.relative_to(command.SOURCE).as_posix(), (command.SOURCE / 'README.md').read_text(encoding='utf-8'))

    def pictures_are_seen(self, seen, width):
        pictures = seen.run('''[...document.images].map(i => { const box = i.getBoundingClientRect();
            return [i.alt, i.complete ? i.naturalWidth : 0, box.left, box.right, box.height, i.checkVisibility()]; })''')
        self.assertEqual([picture[0] for picture in pictures], [figure['title'] for figure in self.drawn()])
        for alt, natural, left, right, tall, shown in pictures:
            self.assertTrue(shown and natural > 100 and tall > 50 and left >= 0 and left + 100 < right <= width, (alt, natural, left, right, tall, shown))

    def tables_sort(self, seen):
        texts = '''(table => [...table.tBodies[0].rows].map(row => [...row.cells].map(cell => cell.textContent)))(document.querySelectorAll('table.sortable')[%d])'''
        changed = 0
        self.assertEqual(seen.run("document.querySelectorAll('table.sortable').length"), self.page.sortable)
        for table in range(self.page.sortable):
            before = seen.run(texts % table)
            for column in range(len(before[0]) if before else 0):
                for direction in ('ascending', 'descending'):
                    said = seen.run(f'''(head => {{ head.click(); return head.getAttribute('aria-sort'); }})(document.querySelectorAll('table.sortable')[{table}].querySelectorAll('th')[{column}])''')
                    self.assertEqual(said, direction)
                    rows = seen.run(texts % table)
                    self.assertEqual(sorted(rows), sorted(before))
                    values = [number(row[column]) for row in rows]
                    if not any(map(math.isnan, values)):
                        self.assertEqual(values, sorted(values, reverse=direction == 'descending'), (table, column))
                    changed += rows != before
        self.assertGreater(changed, self.page.sortable)
