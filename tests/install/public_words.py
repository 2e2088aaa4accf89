# SPDX-License-Identifier: MIT
"""Each public struct, union, field, value of an enum, macro and type of the headers has a word of what it is, and a number with a fraction says its
unit: public_words.py

A word is a comment behind the declaration or right above it; of a value or a field also the comment of its enum or struct where that calls it by its name (or by
what its name ends with: "NONE ..." for VXS_COUPLING_NONE), and of a value that at the head of the file. What stands on one line shares the comment of the line. A unit is "[m]", "[1]"; or a range,
"0 .. 1"; or that it is a quaternion (w x y z) or of length 1. struct_size and reserved say what they are by their names: each header's config has them."""
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve()
SOURCE = HERE.parents[2]
ROOTS = ('runtime/include/voxshell', 'formats/include/voxshell/format')
BY_NAME = {'struct_size', 'reserved'}


class Header:
    """Walks the declarations of a header with the comments at them."""

    def __init__(self, path, text):
        self.path, self.text = path, text
        self.comments = [(m.start(), m.end(), m[1]) for m in re.finditer(r'/\*(.*?)\*/', self.text, re.S)]
        self.blank = re.sub(r'/\*.*?\*/', lambda m: re.sub(r'[^\n]', ' ', m[0]), self.text, flags=re.S)  # same offsets, no comments
        self.head = self.text.split('*/')[0]
        self.found = []  # (kind, name, line, comment)

    def line(self, at):
        return self.text.count('\n', 0, at) + 1

    def behind(self, at):
        """The comment that begins on the line where a declaration ends."""
        end = self.text.find('\n', at)
        return ' '.join(text for begin, _, text in self.comments if at <= begin < end and not self.blank[at:begin].strip(' ;,}'))

    def above(self, at):
        """The comment that ends on the line before a declaration, and is not behind another one."""
        begin = self.text.rfind('\n', 0, at) + 1
        for start, end, text in self.comments:
            if self.text[end:begin].strip(' \t') == '\n' and not self.blank[self.text.rfind('\n', 0, start) + 1:start].strip():
                return text
        return ''

    def note(self, kind, names, begin, end, around=''):
        text = f'{self.above(begin)} {self.behind(end)}'.strip()
        for name in names:
            self.found.append((kind, name, self.line(begin), text or self.within(name, around)))

    @staticmethod
    def within(name, around):
        """The comment of the whole, if it calls the part by its name, or by what the name ends with."""
        parts = name.split('_')
        for n in range(len(parts)):
            last = '_'.join(parts[n:])
            if len(last) > 1 and re.search(rf'(?<!\w){re.escape(last)}(?!\w)', around):
                return around
        return ''


def body_of(text, at):
    """From an opening brace to behind its closing one."""
    depth = 0
    for n in range(at, len(text)):
        depth += {'{': 1, '}': -1}.get(text[n], 0)
        if depth == 0:
            return n + 1
    raise ValueError('a brace is not closed')


def names_of(declaration):
    """Those that a member's declaration declares."""
    pointer = re.search(r'\(\s*\*\s*(\w+)\s*\)', declaration)
    if pointer:
        return [pointer[1]]
    return [m[1] for piece in declaration.rstrip(';').split(',') if (m := re.search(r'(\w+)\s*(?:\[[^\]]*\]\s*)*$', piece))]


def members(header, begin, end, around):
    """Fields of a struct or union between its braces."""
    at = begin
    while (m := re.compile(r'\s*((?:struct|union)\s*\{|[^;{}]+;)').match(header.blank, at, end)):
        start = m.start(1)
        if m[1].endswith('{'):
            close = body_of(header.blank, m.end() - 1)
            stop = header.blank.index(';', close)
            members(header, m.end(), close - 1, f'{around} {header.above(start)}')
            header.note('field', [header.blank[close:stop].strip()], start, stop + 1, around + ' ' + header.blank[close:stop])
            at = stop + 1
        else:
            header.note('number' if re.match(r'(?:const )?(?:double|float)\b', m[1]) else 'field', names_of(m[1]), start, m.end(), around)
            at = m.end()
    if header.blank[at:end].strip():
        raise ValueError(f'{header.path.name}:{header.line(at)}: not understood: {header.blank[at:end].strip()[:60]}')


def declarations(path, text):
    header = Header(path, text)
    for m in re.finditer(r'^[ \t]*#[ \t]*define[ \t]+(\w+)(?:\\\n|[^\n])*', header.blank, re.M):
        stop = m.end() - len(m[0]) + len(m[0].rstrip())
        if not m[1].endswith('_H'):
            header.note('macro', [m[1]], m.start(), stop)
    for m in re.finditer(r'^(typedef )?(struct|union|enum)\s*(\w*)\s*\{', header.blank, re.M):
        close = body_of(header.blank, m.end() - 1)
        stop = header.blank.index(';', close) + 1
        around = f'{header.above(m.start())} {header.behind(stop)}'
        if m[2] == 'enum':
            around += header.head
            for value in re.finditer(r'(?<!\()\b([A-Z]\w+)\b\s*(?:=[^,}]*)?(,|(?=\s*\}))', re.sub(r'^#.*', lambda line: ' ' * len(line[0]), header.blank[m.end():close], flags=re.M)):
                header.note('value', [value[1]], m.end() + value.start(), m.end() + value.start() + len(value[0].rstrip()), around)
        else:
            name = header.blank[close:stop - 1].strip() or m[3]
            header.note(m[2], [name], m.start(), stop)
            members(header, m.end(), close - 1, around)
    for m in re.finditer(r'^typedef (?!struct \w*\s*\{|union|enum)[^;{}]*?(\w+);', header.blank, re.M):
        header.note('type', [m[1]], m.start(), m.end())
    return header.found


def wrong(kind, name, text):
    if name in BY_NAME:
        return None
    if not re.search(r'\w', text):
        return 'has no word of what it is'
    if kind == 'number' and not re.search(r'\[[^\]]+\]|\.\.|\b(w x y z|length 1)\b', text):
        return f'is a number without a unit: "{" ".join(text.split())[:70]}"'
    return None


# What has a word and what has none: each name with LACKS is to be found, and no other.
EXAMPLE = """/* example.h - NAMED_AT_HEAD is a value. */
#define X_GOOD 1 /* a number of things */
#define X_LACKS 2

/* Kinds: FIRST is one. */
enum { X_FIRST = 1, X_NAMED_AT_HEAD = 2 };
enum {
    X_OTHER = 1, /* another */
    X_LACKS_IT = 2
};

/* A thing. */
typedef struct x_thing {
    uint32_t struct_size;
    double length; /* [m] */
    double lacks_unit; /* how heavy it is */
    double share; /* 0 .. 1 */
    /* Called in the tick. */
    void (*act)(void *self);
    void (*lacks_act)(void *self);
    const double *a, *b; /* [N] */
    union {
        double all_lacks[3];
        struct {
            double mass; /* [kg] */
        } body; /* a body's */
    } as; /* by kind */
    uint32_t lacks_count;
} x_thing;

typedef struct x_lacks {
    int n; /* how many */
} x_lacks;
"""


def looks():
    """Whether this test sees what it is for."""
    told = {name for kind, name, _, text in declarations(HERE, EXAMPLE) if wrong(kind, name, text)}
    lacking = set(re.findall(r'\w*(?:LACKS|lacks)\w*', EXAMPLE))
    return [f'public_words: {name} in its own example: {"not seen" if name in lacking else "seen, but has its word"}' for name in sorted(told ^ lacking)]


def main():
    count, problems = 0, looks()
    for root in ROOTS:
        for path in sorted((SOURCE / root).glob('*.h')):
            for kind, name, line, text in declarations(path, path.read_text(encoding='utf-8')):
                count += 1
                what = wrong(kind, name, text)
                if what:
                    problems.append(f'{path.relative_to(SOURCE)}:{line}: {kind} {name} {what}')
    print('\n'.join(problems) or f'{count} structs, fields, values, macros and types, each with its word')
    sys.exit(1 if problems or count < 500 else 0)


if __name__ == '__main__':
    main()
