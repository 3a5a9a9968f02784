#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs a command under strace and checks that every TARGET that it made would survive a power cut: its temporary, made
with O_EXCL and O_NOFOLLOW, is written, then synced, then renamed, then its folder is synced.
A TARGET "in-place:PATH" is made and written under its own name: it is synced after its last write, and its folder after
it was made. Of "content:PATH" the content alone must survive: a list whose loss costs time.
Usage: sync_order.py TARGET... -- COMMAND..."""
import os
import re
import subprocess
import sys
import tempfile

middle = sys.argv.index("--")
kinds = [t.partition(":")[0] if t.startswith(("in-place:", "content:")) else "" for t in sys.argv[1:middle]]
targets = [os.path.realpath(t.removeprefix(kind + ":")) for kind, t in zip(kinds, sys.argv[1:middle])]
command = sys.argv[middle + 1:]
calls = "openat,write,pwrite64,pwritev,fsync,fdatasync,rename,renameat,renameat2"
with tempfile.NamedTemporaryFile("r") as log:
    code = subprocess.run(["strace", "-f", "-y", "-s", "4096", "-e", "trace=" + calls, "-e", "signal=none", "-o", log.name,
                           *command]).returncode
    lines = [line.split(maxsplit=1)[1] for line in log]
if code != 0:
    sys.exit(f"exit code {code}")


def at(pattern, first=0, what=""):
    """The first line from `first` on that the pattern matches."""
    for i in range(first, len(lines)):
        if re.search(pattern, lines[i]):
            return i
    sys.exit(f"{target}: {what}")


written = r"^p?write(64|v)?\(\d+<{name}>"
done = r"(\) *= 0| <unfinished)"  # strace splits a call that another thread interrupts
for kind, target in zip(kinds, targets):
    folder = os.path.dirname(target)
    if kind in ("in-place", "content"):
        name = re.escape(target)
        opened = at(rf'^openat\(.*"{name}".*O_CREAT', what="never made")
        writes = [i for i, line in enumerate(lines) if re.search(written.format(name=name), line)]
        if not writes:
            sys.exit(f"{target}: nothing was written")
        at(rf"^f(data)?sync\(\d+<{name}>{done}", writes[-1], "not synced after its last write")
        if kind == "in-place":
            at(rf"^fsync\(\d+<{re.escape(folder)}>{done}", opened, "its folder was not synced after it was made")
        continue
    renamed = at(rf'^rename\w*\(.*"{re.escape(target)}"', what="never renamed to its name")
    temporary = re.findall(r'"([^"]+)"', lines[renamed])[0]
    name = re.escape(temporary)
    opened = at(rf'^openat\(.*"{name}".*O_CREAT', what="its temporary was never made")
    for flag in ("O_EXCL", "O_NOFOLLOW"):
        if flag not in lines[opened]:
            sys.exit(f"{target}: its temporary was opened without {flag}")
    writes = [i for i in range(opened, len(lines)) if re.search(written.format(name=name), lines[i])]
    if not writes:
        sys.exit(f"{target}: nothing was written")
    synced = at(rf"^f(data)?sync\(\d+<{name}>{done}", writes[-1], "its temporary was not synced after its last write")
    if synced > renamed:
        sys.exit(f"{target}: renamed before it was synced")
    at(rf"^fsync\(\d+<{re.escape(folder)}>{done}", renamed, "its folder was not synced after the renaming")
print(len(targets), "as they should be")
