# SPDX-License-Identifier: Apache-2.0
"""Runs the Python blocks of a page one after the other, as a reader would who copies them: run_snippets.py PAGE.md

What they write goes to a folder that is gone afterwards; they read examples/."""

import os
import pathlib
import re
import sys
import tempfile

page = pathlib.Path(sys.argv[1]).resolve()
root = pathlib.Path.cwd()
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    os.symlink(root / "examples", "examples")
    names = {}
    blocks = list(re.finditer(r"^```python\n(.*?)^```", page.read_text(), re.M | re.S))
    for block in blocks:
        line = page.read_text().count("\n", 0, block.start()) + 2
        exec(compile("\n" * (line - 1) + block.group(1), page.name, "exec"), names)
    os.chdir(root)
if not blocks:
    sys.exit(f"{page}: no Python block")
