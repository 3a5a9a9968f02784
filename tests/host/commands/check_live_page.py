#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of `tactel monitor --serve` in a headless Chromium, fed with frames of two pads whose picture is known.

Usage: check_live_page.py TACTEL [--latency] [--pictures FOLDER]
Prints every problem; ends with 1 where there is one. Checked: lines of the page are those of standard output; tiles, arrows, names, the
words; pads side by side, the curve first, an axis and a scale that hold still; no error, no request elsewhere, no text faint or cut, at
1280 and 390 pixels, light and dark; a page of another site is refused; a silent sensor, a stopped monitor, the end. --latency prints the
time from a frame's write to its picture, ms; --pictures FOLDER keeps what was seen."""
import http.client
import json
import pathlib
import re
import signal
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
        profiles = [pathlib.Path(folder) / name for name in ("left.toml", "right.toml")]
        for profile in profiles:
            profile.write_text(PROFILE)
        self.number, self.out = 0, open(pathlib.Path(folder) / "lines.jsonl", "w+")
        self.process = subprocess.Popen([program, "monitor", "--source", "csv:-", "--profile", profiles[0], "--profile", profiles[1], "--serve", "0", *options],
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


def state(browser):
    return browser.run("(s => [s.querySelector('b').textContent, s.querySelector('span').textContent, s.className])(document.getElementById('state'))")


def until(browser, holds, seconds=5):
    """The state that `holds`, or the last one."""
    end = time.monotonic() + seconds
    while not holds(found := state(browser)) and time.monotonic() < end:
        time.sleep(0.02)
    return found


# The places of what stands on the page: of the curve, and of each pad.
PLACES = """['history', 'pad-0', 'pad-1'].map(id => (r => [r.left, r.top])(document.getElementById(id).getBoundingClientRect()))"""
AXIS = """[...document.querySelectorAll('#history text[text-anchor="end"]')].map(t => t.textContent).join(' ')"""


def newest(monitor, browser, shear):
    """Sends one frame after a pause of the picture, and returns its state."""
    time.sleep(0.05)
    grip(monitor, shear)
    return shown(browser, monitor.number - 1)


def told(monitor, browser, shear):
    """The state at a frame, before half a second without another has passed on a busy machine."""
    for _ in range(20):
        newest(monitor, browser, shear)
        if (found := state(browser))[0] != "no answer":
            break
    return found


def check(program, latency, pictures):
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
                found = told(monitor, browser, 0)
                expect(found == ["below the alarm", "moved is 0 % of it", "state good"], f"{where}: a grip at rest is {found}")
                found = told(monitor, browser, 0.009)  # 0.09 of 0.1 MPa in the right pad
                expect(found == ["near the alarm", "moved is 90 % of it", "state fair"], f"{where}: short of the alarm is {found}")
                axis = browser.run(AXIS)
                found = told(monitor, browser, 0.06)  # both pads: 0.06 and 0.06 of 0.3 MPa, 0.06 of 0.1
                words = browser.run("document.body.innerText")
                expect(found == ["ALARM", "it leaves its hold", "state poor"] and "left moved 0.283" in words.replace("\n", " ") and "right moved 0.600" in words.replace("\n", " "), f"{where}: not the words of an alarm: {words}")
                expect(axis.startswith("0 0.5 1") and "1 is the alarm" in browser.run("document.getElementById('history').textContent"), f"{where}: the axis is {axis}")
                curve, first, second = browser.run(PLACES)
                expect(first[1] == second[1] and first[0] < second[0], f"{where}: pads at {first} and {second} are not side by side")
                expect(curve[1] < first[1] if width < 600 else curve[0] < first[0], f"{where}: the curve at {curve} is not before the pads at {first}")
                if pictures:
                    (pictures / f"live-{width}-{'dark' if dark else 'light'}.png").write_bytes(browser.picture())
                left, right = browser.run(PICTURE)
                expect(len(left["tiles"]) == 2 and len(right["tiles"]) == 2, f"{where}: not two tiles a pad")
                expect(len(set(left["tiles"])) == 2 and left["tiles"][1] == right["tiles"][0], f"{where}: equal pressures have other colours")
                ways = [*left["arrows"], *right["arrows"]]
                expect(len(ways) == 3 and ways[0][0] > 5 > abs(ways[0][1]) and ways[1][1] > 5 > abs(ways[1][0]) and ways[2][1] < -5, f"{where}: arrows {ways}")
                expect(browser.run("document.documentElement.scrollWidth") <= width, f"{where}: too wide")
                for text in browser.faint_texts():
                    expect(False, f"{where}: {text}")
                page = browser.run("tactel.shown().line")
                printed = next(one for one in monitor.lines() if one.get("frame") == monitor.number - 1)
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
            second = subprocess.run([program, "monitor", "--source", "csv:-", "--profile", pathlib.Path(folder) / "left.toml", "--rest", "--touch", "0.01", "--serve", wrong],
                                    stdin=subprocess.DEVNULL, capture_output=True, text=True)
            expect(second.returncode == 2 and f"--serve = {wrong}: " in second.stderr and fix in second.stderr, f"--serve {wrong}: {second.stderr}")

        time.sleep(0.1)
        monitor.send([0, 0, 20, 0, 0, 0.1], [0, 0, 0.1, 0, 0, 0])
        spike = (shown(browser, monitor.number - 1), browser.run("tactel.shown().most"))[1]
        silent = until(browser, lambda s: s[0] == "no answer", 2)
        expect(silent[2] == "state fact" and browser.run("document.querySelector('.live').matches('.silent')"), f"half a second without a frame is {silent}")
        silent = until(browser, lambda s: "the sensor is silent" in s[1], 5)
        expect("the sensor is silent" in silent[1], f"seconds without a frame are {silent}")
        if pictures:
            (pictures / "live-silent.png").write_bytes(browser.picture())
        lines = [one for one in monitor.lines() if one.get("silence")]
        expect(lines and lines[0]["why"] == "silent" and lines[0]["cannot_tell"] is True and "frame" not in lines[0], f"lines of silence: {lines}")
        expect(told(monitor, browser, 0)[0] != "no answer", "a frame does not end the silence")
        monitor.process.send_signal(signal.SIGSTOP)
        stopped = until(browser, lambda s: s[0] == "no answer", 3)
        monitor.process.send_signal(signal.SIGCONT)
        expect("no line from monitor" in stopped[1], f"a stopped monitor is {stopped}")
        time.sleep(9)
        newest(monitor, browser, 0)
        time.sleep(0.3)
        expect(spike == 20 and browser.run("tactel.shown().most") <= 0.2, f"the scale after a spike to {spike} MPa is {browser.run('tactel.shown().most')}")

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
        ended = until(browser, lambda s: s[0] == "ended")
        expect(ended[0] == "ended", f"the end is {ended}")
    return problems


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    pictures = pathlib.Path(sys.argv[sys.argv.index("--pictures") + 1]) if "--pictures" in sys.argv else None
    problems = check(program, "--latency" in sys.argv[2:], pictures)
    print("\n".join(problems))
    return bool(problems)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main())
