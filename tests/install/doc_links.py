# SPDX-License-Identifier: MIT
"""Each link in the documents leads somewhere: files, pictures, headings. (Addresses on the web are not asked.)"""
import os
import pathlib
import re
import subprocess
import sys

SOURCE = pathlib.Path(os.environ.get('VOXSHELL_SOURCE', pathlib.Path(__file__).parents[2])).resolve()


def documents():
    try:
        said = subprocess.run(['git', '-C', SOURCE, 'ls-files', '-co', '--exclude-standard', '*.md'], capture_output=True, text=True, check=True).stdout
        return [SOURCE / name for name in said.splitlines() if (SOURCE / name).exists()]
    except (OSError, subprocess.CalledProcessError):  # an archive
        return [p for p in SOURCE.rglob('*.md') if 'build' not in p.relative_to(SOURCE).parts]


def plain(text):
    """Without code, in which brackets are not links."""
    text = re.sub(r'^( *)(```|~~~).*?^\1\2', '', text, flags=re.M | re.S)
    return re.sub(r'(`+).+?\1', lambda m: 'x' * len(m[0]), text)


def anchors(path):
    out, seen = set(), {}
    text = re.sub(r'^( *)(```|~~~).*?^\1\2', '', path.read_text(encoding='utf-8'), flags=re.M | re.S)
    for title in re.findall(r'^#+ +(.*?) *#*$', text, re.M):
        title = re.sub(r'\[([^]]*)\]\([^)]*\)', r'\1', title)
        slug = re.sub(r'[^\w\- ]', '', title.lower()).replace(' ', '-')
        out.add(slug if slug not in seen else f'{slug}-{seen[slug]}')
        seen[slug] = seen.get(slug, 0) + 1
    return out | set(re.findall(r'<a (?:name|id)="([^"]+)"', text))


def main():
    problems, count = [], 0
    for document in documents():
        text = plain(document.read_text(encoding='utf-8'))
        links = re.findall(r'\]\(<?([^)\s>]+)>?(?: "[^"]*")?\)', text) + re.findall(r'<(?:img|a)\b[^>]*?(?:src|href)="([^"]+)"', text)
        links += re.findall(r'^\[[^]]+\]: +(\S+)', text, re.M)
        for link in links:
            if re.match(r'[a-z]+:', link):
                continue
            count += 1
            name, _, anchor = link.partition('#')
            target = (document.parent / name).resolve() if name else document
            where = f'{document.relative_to(SOURCE)}: {link}'
            if not target.exists():
                problems.append(f'{where}: no such file')
            elif not target.is_relative_to(SOURCE):
                problems.append(f'{where}: leads out of the project')
            elif anchor and target.suffix == '.md' and anchor not in anchors(target):
                problems.append(f'{where}: no such heading')
    print('\n'.join(problems) or f'{count} links')
    sys.exit(1 if problems or not count else 0)


if __name__ == '__main__':
    main()
