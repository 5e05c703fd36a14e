#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Checks that the documentation's links to files and headings of this repository lead somewhere."""

import re
import sys
from pathlib import Path

root = Path(__file__).resolve().parents[2]
fence = re.compile(r'^```.*?^```', re.M | re.S)


def anchors(page):
    """Of the headings, as GitHub names them."""
    titles = re.findall(r'^#+ (.+)$', fence.sub('', page.read_text()), re.M)
    plain = (re.sub(r'\[([^]]*)\]\([^)]*\)', r'\1', title) for title in titles)
    return {re.sub(r'[^\w\- ]', '', title.lower()).replace(' ', '-') for title in plain}


broken = []
for page in [*root.glob('*.md'), *root.glob('docs/**/*.md')]:
    for target, heading in re.findall(r'\]\((?!\w+:)([^)#\s]*)(?:#([^)]+))?\)',
                                      fence.sub('', page.read_text())):
        file = (page.parent / target) if target else page
        if not file.exists() or heading and file.suffix == '.md' and heading not in anchors(file):
            broken.append(f'{page.relative_to(root)}: {target}{"#" + heading if heading else ""}')
print('\n'.join(broken))
sys.exit(bool(broken))
