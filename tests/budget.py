#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs ctest and fails where the tests took more processor time than they may: budget.py SECONDS ctest [OPTION...]

Prints the processor time of all tests together, the 20 tests that took longest, by the clock, and what the failed ones said last. The processor time of a busy machine is
that of an idle one, to some tens of percent; SECONDS leave room for a processor of half the speed."""
import pathlib
import resource
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

SHOWN = 20
LAST_LINES = 15


def main(budget, *command):
    with tempfile.TemporaryDirectory() as folder:
        results = pathlib.Path(folder) / "tests.xml"
        status = subprocess.run([*command, "--output-junit", results], check=False).returncode
        cases = xml.parse(results).getroot().findall("testcase") if results.exists() else []
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = used.ru_utime + used.ru_stime
    for case in sorted(cases, key=lambda case: -float(case.get("time")))[:SHOWN]:
        print(f"{float(case.get('time')):8.1f} s  {case.get('name')}")
    print(f"{len(cases)} tests took {seconds:.0f} s of a processor; they may take {budget} s")
    if seconds > float(budget):
        print("over budget: make a test smaller, or leave it to scripts/nightly (a suite called ...Nightly)")
    for case in cases:
        if case.get("status") == "fail":
            said = (case.findtext("system-out") or "").rstrip().splitlines()
            print(f"failed: {case.get('name')}", *said[-LAST_LINES:], sep="\n  ")
    return status or int(seconds > float(budget))


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
