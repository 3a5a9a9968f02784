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
    "contact": ("examples/parabola.toml", 5, ".controls, .panels"),
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


def live(browser, tactel, folder):
    """Four seconds of a drag, after two grips."""
    scene = re.search(r"cat > grip.toml <<'?END'?\n(.*?)\nEND", (ROOT / "docs/pad-to-alarm.md").read_text(), re.S).group(1)
    (folder / "grip.toml").write_text(scene)
    for dark in (False, True):
        with subprocess.Popen([tactel, "monitor", "--source", "simulate:grip.toml?rest=1&hold=1&time_constant=0&repeat=3", "--network", "uskin-4x4", "--touch",
                               "0.002", "--alarm", "0.05", "--serve", "0", "--quiet"], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as monitor:
            browser.open(re.search(r"http://\S+", monitor.stderr.readline()).group(), width=1000, dark=dark)
            while not browser.run("tactel.shown().line?.frame > 1380"):
                time.sleep(0.02)
            browser.run("document.querySelectorAll('h1, .subtitle').forEach(e => e.remove())")
            (ROOT / f"docs/live{'-dark' if dark else ''}.webp").write_bytes(browser.picture("main", kind="webp"))
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
