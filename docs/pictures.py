#!/usr/bin/env python3
"""Draws the pictures of the manual, docs/NAME.webp and docs/NAME-dark.webp, from pages of examples.

Usage: docs/pictures.py [TACTEL [NAME]]  (the program, build/tactel by default; one picture, all by default)
A headless Chromium shows what `tactel solve EXAMPLE --html` writes; a picture is the read-out and the maps of its figure. "live" is the
page of `tactel monitor --serve`, of the grip of docs/pad-to-alarm.md."""
import pathlib
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/host/figures"))
from browser import Browser  # noqa: E402

WIDTH = 860  # pixels of the page

# Example, load step that is shown, and what the picture leaves out of the figure. On the line tractions stay, on the pad the colour scale.
PICTURES = {
    "contact": ("examples/cylinder.toml", 4, ".controls, .panels"),
    "pad": ("examples/pad_twist.toml", 4, ".controls:has(input), .choice, .drawing > :last-child"),
}

TRIM = """(() => {
  document.querySelectorAll('h1, .subtitle, .verdict, nav, figcaption, .tools').forEach(e => e.remove());
  document.querySelectorAll('figure[data-kind="table"]').forEach(e => e.remove());
  const figure = document.querySelector('figure');
  document.querySelector('main').style.padding = '0';
  figure.style.margin = '0';
  tactel.figures.forEach(f => f.draw());  // at the new width
  figure.querySelectorAll('LEFT_OUT').forEach(e => e.remove());
})()"""


def chunks(webp):
    """The chunks of a WebP file, each with its name and head (Google, WebP container specification)."""
    at = 12
    while at < len(webp):
        size = int.from_bytes(webp[at + 4:at + 8], "little")
        yield webp[at:at + 4], webp[at:at + 8 + size + size % 2]
        at += 8 + size + size % 2


def animation(pictures, width, height, milliseconds):
    """One WebP of several of `width` x `height` pixels, shown for so long each, again and again."""
    def chunk(name, data):
        return name + len(data).to_bytes(4, "little") + data + b"\0" * (len(data) % 2)

    def number(value):
        return value.to_bytes(3, "little")

    size = number(width - 1) + number(height - 1)
    frames = [chunk(b"ANMF", number(0) + number(0) + size + number(milliseconds) + b"\2" + b"".join(c for name, c in chunks(p) if name in (b"VP8 ", b"VP8L", b"ALPH")))
              for p in pictures]
    body = b"WEBP" + chunk(b"VP8X", b"\2\0\0\0" + size) + chunk(b"ANIM", b"\xff" * 4 + b"\0\0") + b"".join(frames)
    return b"RIFF" + len(body).to_bytes(4, "little") + body


def live(browser, tactel, folder):
    """The third of three grips, from its press on."""
    scene = re.search(r"cat > grip.toml <<'?END'?\n(.*?)\nEND", (ROOT / "docs/pad-to-alarm.md").read_text(), re.S).group(1)
    (folder / "grip.toml").write_text(scene)
    first, last, every = 1130, 1450, 16  # frames of the sensor, 100 a second
    for dark in (False, True):
        with subprocess.Popen([tactel, "monitor", "--source", "simulate:grip.toml?rest=1&hold=1&time_constant=0&repeat=3", "--touch", "0.002", "--rest", "--alarm",
                               "--serve", "0", "--quiet"], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as monitor:
            browser.open(re.search(r"http://\S+", monitor.stderr.readline()).group(), width=940, dark=dark)
            while not browser.run("tactel.shown().line"):
                time.sleep(0.02)
            browser.run("document.querySelectorAll('h1, .subtitle').forEach(e => e.remove()); document.querySelector('main').style.padding = '1px 1rem 1rem'")
            pictures = []
            for frame in range(first, last, every):
                while browser.run("tactel.shown().line.frame") < frame:
                    time.sleep(0.005)
                pictures.append(browser.picture("main", kind="webp", quality=70))
            box = browser.run("(r => [r.width, r.height])(document.querySelector('main').getBoundingClientRect())")
            (ROOT / f"docs/live{'-dark' if dark else ''}.webp").write_bytes(animation(pictures, *map(round, box), 10 * every))
            monitor.kill()


def main():
    tactel = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/tactel"
    with tempfile.TemporaryDirectory() as folder, Browser() as browser:
        if "live" in (sys.argv[2:] or ["live"]):
            live(browser, pathlib.Path(tactel).resolve(), pathlib.Path(folder))
        for name, (example, step, left_out) in PICTURES.items():
            if name not in (sys.argv[2:] or PICTURES):
                continue
            page = pathlib.Path(folder) / "contact.html"
            subprocess.run([tactel, "solve", ROOT / example, "--html", page, "--step", str(step), "--quiet"], check=True, stdout=subprocess.DEVNULL)
            for dark in (False, True):
                browser.open(page, width=WIDTH, dark=dark, sharp=2)
                browser.run(TRIM.replace("LEFT_OUT", left_out))
                (ROOT / f"docs/{name}{'-dark' if dark else ''}.webp").write_bytes(browser.picture("figure", kind="webp"))


if __name__ == "__main__":
    main()
