#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs ctest and fails where the tests took more processor time than they may: budget.py SECONDS ctest [OPTION...]

Prints the processor time of all tests together, the 20 tests that took longest, by the clock, and what the failed ones said last.
SECONDS are those of a processor on which Python counts to fifty million in one second: here they are as much longer as it takes to count."""
import pathlib
import resource
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as xml

SHOWN = 20
LAST_LINES = 15


def counting():
    """Processor seconds, of the best of three."""
    taken = []
    for _ in range(3):
        start = time.process_time()
        for _ in range(5 * 10**7):
            pass
        taken.append(time.process_time() - start)
    return min(taken)


def main(budget, *command):
    with tempfile.TemporaryDirectory() as folder:
        results = pathlib.Path(folder) / "tests.xml"
        status = subprocess.run([*command, "--output-junit", results], check=False).returncode
        cases = xml.parse(results).getroot().findall("testcase") if results.exists() else []
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = used.ru_utime + used.ru_stime
    for case in sorted(cases, key=lambda case: -float(case.get("time")))[:SHOWN]:
        print(f"{float(case.get('time')):8.1f} s  {case.get('name')}")
    allowed = float(budget) * counting()
    print(f"{len(cases)} tests took {seconds:.0f} s of a processor; they may take {allowed:.0f} s of this one")
    if seconds > allowed:
        print("over budget: make a test smaller, or leave it to scripts/nightly (a suite called ...Nightly)")
    for case in cases:
        if case.get("status") == "fail":
            said = (case.findtext("system-out") or "").rstrip().splitlines()
            print(f"failed: {case.get('name')}", *said[-LAST_LINES:], sep="\n  ")
    return status or int(seconds > allowed)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
