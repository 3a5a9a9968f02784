# SPDX-License-Identifier: Apache-2.0
"""Opens a page in a headless Chromium and checks what people meet.

Usage: check_page.py SAMPLE_PAGE  (a program that writes a page to the file it is given)
       check_page.py FILE.html
Prints every problem; ends with 1 where there is one. Checked at 1280 and 390 pixels, light and dark: no error in the console, no
request, no horizontal scrolling (of tables at 1280), no text cut, figures drawn; the slider changes the picture; CSV holds the data; the page prints."""
import os
import pathlib
import subprocess
import sys
import tempfile

from browser import Browser

LARGEST_PAGE = 500_000  # bytes, host/figures/page.h

# Figures without a drawing, drawings wider than their box, texts beyond the page's edge.
FAULTS = """(() => {
  const out = [];
  for (const figure of document.querySelectorAll('figure[data-kind="chart"], figure[data-kind="contact"]')) {
    const svgs = figure.querySelectorAll('.drawing svg');
    if (!svgs.length) out.push(figure.id + ' is not drawn');
    for (const svg of svgs)
      if (svg.getBoundingClientRect().right > figure.getBoundingClientRect().right + 1) out.push(figure.id + ': a drawing is too wide');
    for (const text of figure.querySelectorAll('.drawing svg text')) {
      const box = text.getBoundingClientRect();
      if (box.width && (box.left < -1 || box.right > innerWidth + 1)) out.push(`${figure.id}: "${text.textContent}" is cut`);
    }
    if (/NaN|undefined|Infinity/.test(figure.querySelector('.drawing').innerHTML.replace(/data:[^"]*/g, ''))) out.push(figure.id + ' has NaN or undefined in its drawing');
  }
  return out;
})()"""

SCROLLED = """[...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth).map(e => e.closest('figure').id)"""


def check_layout(browser, path, expect):
    pictures = set()
    for width in (1280, 390):
        for dark in (False, True):
            where = f"{width} pixels, {'dark' if dark else 'light'}"
            browser.open(path, width=width, dark=dark)
            scroll = browser.run("document.documentElement.scrollWidth")
            expect(scroll <= width, f"{where}: the page is {scroll} pixels wide")
            for table in browser.run(SCROLLED) if width == 1280 else []:
                expect(False, f"{where}: {table} scrolls")
            for fault in browser.run(FAULTS):
                expect(False, f"{where}: {fault}")
            smallest = browser.run("Math.min(...[...document.querySelectorAll('svg text, p, td, figcaption')].map(e => parseFloat(getComputedStyle(e).fontSize)))")
            expect(smallest >= 11, f"{where}: letters of {smallest} pixels")
            pictures.add(browser.picture(whole=False))
    expect(len(pictures) == 4, "the page looks the same in two of four settings")


def check_slider(browser, path, expect):
    """Every slider: each step has a picture of its own, and the read-out follows."""
    browser.open(path)
    sliders = browser.run("document.querySelectorAll('input[type=range]').length")
    for k in range(sliders):
        find = f"document.querySelectorAll('input[type=range]')[{k}]"
        stage = f"document.querySelectorAll('.stage')[{k}]"
        steps = int(browser.run(f"{find}.max"))
        seen, numbers = set(), set()
        for step in sorted({0, steps // 2, steps}):
            browser.run(f"{find}.value = {step}; {find}.dispatchEvent(new Event('input', {{bubbles: true}}))")
            seen.add(browser.run(f"{stage}.querySelector('svg').innerHTML + {stage}.querySelector('canvas').toDataURL()"))
            numbers.add(browser.run(f"document.querySelectorAll('.readout')[{k}].textContent"))
        expect(len(seen) == len(numbers) == len({0, steps // 2, steps}), f"slider {k} does not change the picture")
        buttons = browser.run(f"(() => {{ const out = new Set(); const figure = {find}.closest('figure'); for (const b of figure.querySelectorAll('.choice button')) {{ b.click(); out.add(figure.querySelector('canvas').toDataURL()); }} return out.size; }})()")
        expect(buttons == 3, f"the stresses of contact {k} have {buttons} pictures instead of 3")
    return sliders


def check_known_numbers(browser, path, expect):
    """The sample's first figure as CSV, written by hand."""
    browser.open(path)
    csv = browser.run("tactel.csvText(tactel.figures[0].rows())")
    by_hand = ('panel,series,x axis,x,y axis,y,low,high\n'
               '"panel, ""one""",a,time (s),0,σ_y (MPa),1.5,,\n"panel, ""one""",a,time (s),0.5,σ_y (MPa),,,\n"panel, ""one""",a,time (s),1,σ_y (MPa),-2,,\n'
               '"panel, ""one""",b,time (s),0,σ_y (MPa),3,2,5\n"panel, ""one""",b,time (s),1,σ_y (MPa),4,3,6\n')
    expect(csv == by_hand, f"CSV of the first figure:\n{csv}instead of\n{by_hand}")
    rows = browser.run("(v => [v.surfaceRows().length - 1, v.data.steps.length * v.data.surface_x.length, v.tactelRows().length - 1, v.data.steps.length * v.data.tactel_x.length, v.fieldRows().length - 1, v.data.steps.length * 81 * 13])(tactel.figures.find(f => f.view).view)")
    expect(rows[0] == rows[1] and rows[2] == rows[3] and rows[4] == rows[5], f"rows of the contact's CSV: {rows}")
    clicked = browser.run("(() => { const b = [...document.querySelectorAll('.tools button')]; b.forEach(x => x.click()); return b.length; })()")
    expect(clicked >= 6, f"{clicked} buttons save CSV")


def check(path, sample, problems):
    def expect(good, problem):
        if not good:
            problems.append(problem)

    size = os.path.getsize(path)
    expect(size < LARGEST_PAGE, f"{size} bytes, {LARGEST_PAGE} at most")
    with Browser() as browser:
        check_layout(browser, path, expect)
        sliders = check_slider(browser, path, expect)
        if sample:
            expect(sliders == 1, f"{sliders} sliders instead of 1")
            check_known_numbers(browser, path, expect)
        expect(len(browser.pdf()) > 10_000, "the page does not print")
        problems += [f"console: {text}" for text in browser.problems]
        problems += [f"requests {url}" for url in set(browser.requests) if not url.startswith(("file:", "data:", "blob:"))]


def main(argument):
    problems = []
    if argument.endswith(".html"):
        check(argument, False, problems)
    else:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "sample.html"
            subprocess.run([argument, path], check=True)
            check(path, True, problems)
    print("\n".join(problems) or "no problem")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
