#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts the lines of the product, .cpp .h .cl .c under host fem nn hw kernels, and fails where they are more than the budget:
tests/lines.py ROOT. A change that needs more raises BUDGET in the same commit, and says why."""
import pathlib
import sys

BUDGET = 81_480

root = pathlib.Path(sys.argv[1])
files = [path for folder in ("host", "fem", "nn", "hw", "kernels") for path in (root / folder).rglob("*") if path.suffix in (".cpp", ".h", ".cl", ".c")]
lines = sum(path.read_bytes().count(b"\n") for path in files)
print(f"{lines} lines in {len(files)} files; they may be {BUDGET}")
sys.exit(lines > BUDGET or not files)
