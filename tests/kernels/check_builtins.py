#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kernels call no function of OpenCL whose last bits the standard leaves open: tests/kernels/check_builtins.py KERNELS

fma, sqrt, quotients, rint, ldexp and comparisons are exact or rounded correctly; what else a kernel needs stands in
kernels/shared/elementary.h. Prints FILE:LINE: NAME for each call, and fails where there is one.
"""
import pathlib
import re
import sys

OPEN = (r"\b((?:native|half)_\w+|a?(?:sin|cos|tan)h?(?:pi)?|atan2(?:pi)?|sincos|exp(?:2|10|m1)?|log(?:2|10|1p|b)?|pow[nr]?|rootn|[rc]bsqrt|"
        r"rsqrt|cbrt|hypot|erfc?|[tl]gamma(?:_r)?|mad|mix|smoothstep|dot|cross|length|distance|normalize|fast_\w+)\s*\(")


def without_comments(text):
    return re.sub(r"//[^\n]*|/\*.*?\*/", lambda comment: re.sub(r"[^\n]", " ", comment[0]), text, flags=re.S)


def main(folder):
    files = sorted(path for path in folder.rglob("*") if path.suffix in (".cl", ".h"))
    calls = []
    for path in files:
        text = without_comments(path.read_text(encoding="utf-8"))
        own = set(re.findall(r"^(?:static inline|INLINE) \w+ (\w+)\(", text, re.M))
        calls += [f"{path}:{text.count(chr(10), 0, call.start()) + 1}: {call[1]}"
                  for call in re.finditer(OPEN, text) if call[1] not in own]
    for call in calls:
        print(f"{call}: its last bits differ between drivers; write it in shared/elementary.h")
    return len(calls) > 0 or len(files) < 30


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
