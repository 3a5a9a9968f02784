#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of `tactel monitor --serve` in a headless Chromium, fed with frames of two pads whose picture is known.

Usage: check_live_page.py TACTEL [--latency]
Prints every problem; ends with 1 where there is one. Checked: lines of the page are those of standard output; tiles, arrows, names, the
word of the alarm; no error, no request elsewhere, no text faint or cut, at 1280 and 390 pixels, light and dark; a page of another site
is refused; the end. --latency prints the time from a frame's write to its picture, ms."""
import http.client
import json
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "figures"))
from browser import Browser  # noqa: E402

PROFILE = """[format]
kind = "csv"
channels = 6
[pad]
tactels = [2, 1]
pitch = 4
[channels]
normal = [2, 5]
shear_x = [0, 3]
shear_y = [1, 4]
[calibration]
gain = [1, 1, -1, 1, 1, -1]
offset = 0
noise = 1e-4
"""

# Tiles of each pad from left to right with their colour; the ways of its arrows, y upwards.
PICTURE = """[...document.querySelectorAll('[id^="pad-"]')].map(pad => ({
  tiles: [...pad.querySelectorAll('rect')].map(r => r.getAttribute('fill')),
  arrows: pad.querySelector('path[stroke-width="1.8"]').getAttribute('d').split('M').slice(1).map(d => d.split(/[L,]/).map(Number)).map(([a, b, c, d]) => [c - a, b - d])}))"""


class Monitor:
    """The program on two pads, fed by lines on its standard input."""

    def __init__(self, program, folder, *options):
        profile = pathlib.Path(folder) / "pad.toml"
        profile.write_text(PROFILE)
        self.number, self.out = 0, open(pathlib.Path(folder) / "lines.jsonl", "w+")
        self.process = subprocess.Popen([program, "monitor", "--source", "csv:-", "--profile", profile, "--profile", profile, "--serve", "0", *options],
                                        stdin=subprocess.PIPE, stdout=self.out, stderr=subprocess.PIPE, text=True)
        self.address = next(m.group() for m in (re.search(r"http://\S+", line) for line in self.process.stderr) if m)

    def send(self, left, right):
        """Of each pad [shear_x, shear_y, pressure] of two tactels, MPa."""
        self.process.stdin.write(",".join(map(str, [*left, *right])) + "\n")
        self.process.stdin.flush()
        self.number += 1

    def lines(self):
        self.out.seek(0)
        return [json.loads(line) for line in self.out]


def grip(monitor, shear=0.0):
    monitor.send([shear, 0, 0.2, 0, shear, 0.1], [0, -shear, 0.1, 0, 0, 0])


def shown(browser, number, seconds=10):
    """Waits until the page has drawn frame `number`; returns what it shows."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        state = browser.run("(s => ({frame: s.line && s.line.frame, painted: s.painted}))(tactel.shown())")
        if state["frame"] == number and state["painted"]:
            return state
    raise RuntimeError(f"frame {number} was not drawn in {seconds} s, but {state}")


def newest(monitor, browser, shear):
    """Sends one frame after a pause of the picture, and returns its state."""
    time.sleep(0.05)
    grip(monitor, shear)
    return shown(browser, monitor.number - 1)


def check(program, latency):
    problems = []

    def expect(holds, text):
        if not holds:
            problems.append(text)

    with tempfile.TemporaryDirectory() as folder, Browser() as browser:
        monitor = Monitor(program, folder, "--rest", "--alarm", "0.1", "--touch", "0.01", "--stresses", "--late", "100")
        for _ in range(40):
            grip(monitor)
            time.sleep(0.01)
        for width in (1280, 390):
            for dark in (False, True):
                where = f"{width} pixels, {'dark' if dark else 'light'}"
                browser.open(monitor.address, width=width, dark=dark)
                newest(monitor, browser, 0)
                expect(browser.run("document.querySelector('#state b').textContent") == "holds", f"{where}: a grip at rest does not hold")
                newest(monitor, browser, 0.06)  # both pads: 0.06 and 0.06 of 0.3 MPa, 0.06 of 0.1
                words = browser.run("document.body.innerText")
                expect("ALARM" in words and "moved 0.600" in words and "moved 0.283" in words, f"{where}: not the words of an alarm: {words}")
                left, right = browser.run(PICTURE)
                expect(len(left["tiles"]) == 2 and len(right["tiles"]) == 2, f"{where}: not two tiles a pad")
                expect(len(set(left["tiles"])) == 2 and left["tiles"][1] == right["tiles"][0], f"{where}: equal pressures have other colours")
                ways = [*left["arrows"], *right["arrows"]]
                expect(len(ways) == 3 and ways[0][0] > 5 > abs(ways[0][1]) and ways[1][1] > 5 > abs(ways[1][0]) and ways[2][1] < -5, f"{where}: arrows {ways}")
                expect(browser.run("document.documentElement.scrollWidth") <= width, f"{where}: too wide")
                for text in browser.faint_texts():
                    expect(False, f"{where}: {text}")
                page = browser.run("tactel.shown().line")
                printed = next(one for one in monitor.lines() if one["frame"] == monitor.number - 1)
                expect(page == printed, f"{where}: the page has {page}, standard output {printed}")
                newest(monitor, browser, 0)
        expect(not browser.problems, f"console: {browser.problems}")
        elsewhere = [r for r in browser.requests if not r.startswith((monitor.address, "data:", "about:", "blob:"))]
        expect(not elsewhere, f"requests {elsewhere}")

        place = urllib.parse.urlsplit(monitor.address).netloc
        other = http.client.HTTPConnection(place, timeout=5)
        other.request("GET", "/events", headers={"Host": "example.org"})
        expect(other.getresponse().status == 403, "a page of another site is answered")
        for wrong, fix in ((place, "free"), ("x", "PORT or ADDRESS:PORT"), ("127.0.0.1:65536", "0 to 65535"), ("203.0.113.1:0", "of this machine")):
            second = subprocess.run([program, "monitor", "--source", "csv:-", "--profile", pathlib.Path(folder) / "pad.toml", "--rest", "--touch", "0.01", "--serve", wrong],
                                    stdin=subprocess.DEVNULL, capture_output=True, text=True)
            expect(second.returncode == 2 and f"--serve = {wrong}: " in second.stderr and fix in second.stderr, f"--serve {wrong}: {second.stderr}")

        if latency:
            times = []
            for k in range(200):
                time.sleep(0.05)
                start = time.time()
                grip(monitor, 1e-4 * k)
                times.append(shown(browser, monitor.number - 1)["painted"] - 1e3 * start)
            print(f"from a frame's write to its picture: median {statistics.median(times):.0f} ms, largest of 200 {max(times):.0f} ms")
        monitor.process.stdin.close()
        monitor.process.wait(20)
        deadline = time.monotonic() + 5
        while "ended" not in browser.run("document.querySelector('#state').textContent") and time.monotonic() < deadline:
            time.sleep(0.05)
        expect("ended" in browser.run("document.querySelector('#state').textContent"), "the end is not shown")
    return problems


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    problems = check(program, "--latency" in sys.argv[2:])
    print("\n".join(problems))
    return bool(problems)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main())
