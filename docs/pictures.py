#!/usr/bin/env python3
"""Draws the picture of README.md, docs/contact.webp and docs/contact-dark.webp, from the page of examples/parabola.toml.

Usage: docs/pictures.py [TACTEL]  (the program, build/tactel by default)
A headless Chromium shows what `tactel solve examples/parabola.toml --html` writes; the picture is its cross-section and tractions."""
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/host/figures"))
from browser import Browser  # noqa: E402

WIDTH = 860  # pixels of the page
STEP = 5     # load step that is shown

# Leaves the read-out, the cross-section and the tractions on the page.
TRIM = """(() => {
  document.querySelectorAll('h1, .subtitle, .verdict, nav, figcaption, .tools, .controls').forEach(e => e.remove());
  document.querySelectorAll('figure[data-kind="table"]').forEach(e => e.remove());
  const figure = document.querySelector('figure');
  document.querySelector('main').style.padding = '0';
  figure.style.margin = '0';
  tactel.figures.forEach(f => f.draw());  // at the new width
  figure.querySelectorAll('.panels').forEach(e => e.remove());
})()"""


def main():
    tactel = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/tactel"
    with tempfile.TemporaryDirectory() as folder, Browser() as browser:
        page = pathlib.Path(folder) / "contact.html"
        subprocess.run([tactel, "solve", ROOT / "examples/parabola.toml", "--html", page, "--step", str(STEP), "--quiet"], check=True, stdout=subprocess.DEVNULL)
        for dark in (False, True):
            browser.open(page, width=WIDTH, dark=dark, sharp=2)
            browser.run(TRIM)
            (ROOT / f"docs/contact{'-dark' if dark else ''}.webp").write_bytes(browser.picture("figure", kind="webp"))


if __name__ == "__main__":
    main()
