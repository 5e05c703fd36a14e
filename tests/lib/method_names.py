#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Checks that the code has what docs/method.md names in `code`.

The functions of the page's first table must be in the files of their row.
"""

import re
import sys
from pathlib import Path

root = Path(__file__).resolve().parents[2]
page = root / 'docs' / 'method.md'


def find(*patterns):
    return [path for pattern in patterns for path in root.glob(pattern)]


def code(path):
    return re.sub(r'//.*', '', path.read_text()) if path.suffix in ('.h', '.cpp') else ''


def missing(name, files):
    """Which part of name, name::member or name=value none of `files` has.

    A member must be in the file of its type.
    """
    texts = list(map(code, files))
    if '::' in name:
        owner, name = name.split('::')
        texts = [text for text in texts if re.search(rf'\b(class|struct) {owner}\b[^;]*{{', text)]
        if not texts:
            return owner
    for part in name.split('='):
        if not any(re.search(rf'(?<![\w-]){re.escape(part)}(?![\w-])', text) for text in texts):
            return part
    return None


errors = []
for number, line in enumerate(page.read_text().splitlines(), 1):
    cells = line.strip('|').split('|')
    # paper | what | file | function
    in_table = len(cells) == 4 and cells[2].strip().startswith('`')
    stems = re.findall('`([^`]+)`', cells[2]) if in_table else []
    patterns = [f'core/{stem}.*' for stem in stems] if in_table else ['core/**/*.*', 'gst/*.*']
    files = find(*patterns)
    for name in re.findall('`([^`]+)`', line):
        if '/' in name:  # a file, a program or a room, with or without its ending
            file = name.split()[0].removeprefix('build/').rstrip('/')
            if not find(file, f'{file}.*', f'core/{file}', f'core/{file}.*'):
                errors.append(f'{number}: there is no {file}')
        elif part := missing(name, files):
            errors.append(f'{number}: no `{part}` in {", ".join(stems) or "core/ and gst/"}')
if errors:
    sys.exit('\n'.join(f'error: {page}:{error}' for error in errors))
