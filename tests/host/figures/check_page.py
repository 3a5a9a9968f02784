# SPDX-License-Identifier: Apache-2.0
"""Opens a page in a headless Chromium and checks what people meet.

Usage: check_page.py SAMPLE_PAGE  (a program that writes a page and a VTU file to the files it is given)
       check_page.py FILE.html
Prints every problem; ends with 1 where there is one. Checked at 1280 and 390 pixels, light and dark: no error in the console, no
request, no horizontal scrolling (of tables at 1280), no text cut or faint, figures drawn; the slider changes the picture; CSV holds the data; the page prints."""
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import check_vtu
from browser import Browser

LARGEST_PAGE = 500_000  # bytes, host/figures/page.h

# Figures without a drawing, drawings wider than their box, texts beyond the page's edge.
FAULTS = """(() => {
  const out = [];
  for (const figure of document.querySelectorAll('figure[data-kind="chart"], figure[data-kind="contact"], figure[data-kind="pad"]')) {
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


# What a contact's stage shows; numbers of clip paths count on.
PICTURE = """(stage => stage.innerHTML.replace(/clip-\\d+/g, '') + [...stage.querySelectorAll('canvas')].map(c => c.toDataURL()))"""

# Of the first pad: where the contact lies on the pad, ways of Q and of the shear, the angle of x', marks, the tip over a cell.
PAD = """(() => {
  const figure = document.querySelector('figure[data-kind="pad"]'), [surface, pad] = figure.querySelectorAll('.stage svg[role="img"]');
  const view = tactel.figures.find(f => f.name === figure.id).view, step = view.data.steps[view.index];
  const middle = node => { const r = node.getBoundingClientRect(); return [(r.left + r.right) / 2, (r.top + r.bottom) / 2]; };
  const ends = d => d.match(/-?[0-9.]+/g).map(Number);
  const filled = (name, round) => [...surface.querySelectorAll('path')].filter(p => p.getAttribute('fill') === `var(--${name})` && p.getAttribute('d').includes('a') === round).length;
  const paths = [...pad.querySelectorAll('path')], cells = [...surface.querySelectorAll('path')].filter(p => p.getAttribute('fill').startsWith('rgb'));
  const q = ends(paths.find(p => p.getAttribute('stroke') === 'var(--purple)').getAttribute('d'));
  const own = ends(paths.find(p => p.getAttribute('stroke-dasharray') === '9 3 2 3').getAttribute('d'));
  const arc = paths.find(p => p.getAttribute('stroke') === 'var(--orange)').getAttribute('d').match(/A[^ ]+ 0 [01] ([01])/)[1];
  const tiles = [...pad.querySelectorAll('rect[rx]')], shafts = [...surface.querySelectorAll('path')].filter(p => p.getAttribute('stroke-width') === '1.4')[0].getAttribute('d');
  const k = step.p.indexOf(Math.max(...step.p)), k_cell = [...step.status].slice(0, k).filter(s => s !== 'o').length, [x, y] = middle(cells[k_cell]);
  surface.dispatchEvent(new PointerEvent('pointermove', {clientX: x, clientY: y, bubbles: true}));
  const shown = document.querySelector('.tip').textContent;
  const [rubber, touched] = [paths[0], paths.find(p => p.getAttribute('stroke-width') === '1.3')].map(middle);
  const marks = {stick: filled('green', true), slip: filled('red', false)};
  const shear = shafts.split('M').slice(1).map(ends).reduce((sum, [x1, y1, x2, y2]) => [sum[0] + x2 - x1, sum[1] + y1 - y2], [0, 0]);
  return {contact: [touched[0] - rubber[0], rubber[1] - touched[1]], q: [q[2] - q[0], q[1] - q[3]], yaw: Math.atan2(own[1] - own[3], own[2] - own[0]) * 180 / Math.PI, arc, marks, shear,
    tiles: tiles.map(t => [...middle(t), ...ends(t.getAttribute('fill'))]), cells: cells.length, shown, step, count: {stick: step.status.split('t').length - 1, slip: step.status.split('l').length - 1},
    rows: view.surfaceRows().slice(1).filter(r => r[0] === step.number).map(r => [r[1], r[2], r[4]]), tactels: view.tactelRows().length - 1, path: view.pathRows().length - 1, steps: view.data.steps.length};
})()"""


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
            for text in browser.faint_texts():
                expect(False, f"{where}: {text}")
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
            seen.add(browser.run(PICTURE + f"({stage})"))
            numbers.add(browser.run(f"document.querySelectorAll('.readout')[{k}].textContent"))
        expect(len(seen) == len(numbers) == len({0, steps // 2, steps}), f"slider {k} does not change the picture")
        buttons = browser.run(f"(() => {{ const out = new Set(); const figure = {find}.closest('figure'); for (const b of figure.querySelectorAll('.choice button')) {{ b.click(); out.add({PICTURE}(figure.querySelector('.stage'))); }} return out.size; }})()")
        expect(buttons == 3, f"the quantities of contact {k} have {buttons} pictures instead of 3")
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


def check_pad(browser, path, expect, vtu):
    """The sample's pad: pressed up and to the right of the middle, turned by 30 degrees, dragged to +x and +y, twisted by +0.1."""
    browser.open(path)
    seen = browser.run(PAD)
    step = seen["step"]
    expect(seen["contact"][0] > 10 and seen["contact"][1] > 10, f"the contact lies at {seen['contact']} pixels from the pad's middle instead of right and up")
    expect(seen["q"][0] > 5 and 0 < seen["q"][1] < seen["q"][0], f"the arrow of Q is {seen['q']}")
    way = math.degrees(math.atan2(seen["shear"][1], seen["shear"][0]) - math.atan2(step["Q"][1], step["Q"][0]))
    expect(math.hypot(*seen["shear"]) > 20 and abs(way) < 10, f"arrows of shear sum to {seen['shear']} pixels, {way} degrees off Q")
    expect(abs(seen["yaw"] - 30) < 0.1, f"x' is at {seen['yaw']} degrees instead of 30")
    expect((seen["arc"] == "0") == (step["M"] > 0) and step["M"] > 0, f"the arc of M = {step['M']} has sweep {seen['arc']}")
    expect(seen["marks"] == seen["count"], f"marks {seen['marks']}, cells {seen['count']}")
    expect(seen["cells"] == sum(seen["count"].values()) and len(seen["tiles"]) == 24, f"{seen['cells']} cells and {len(seen['tiles'])} tactels are drawn")
    first, second, above = seen["tiles"][0], seen["tiles"][1], seen["tiles"][6]
    expect(second[0] > first[0] + 10 and second[1] == first[1] and above[0] == first[0] and above[1] < first[1] - 10, "tactels are not drawn from the lower left on, along x")
    expect(min(range(24), key=lambda k: seen["tiles"][k][2] - seen["tiles"][k][4]) == min(range(24), key=lambda k: step["sigma"][k]), "the bluest tactel is not the one that is compressed most")
    expect(f"p {max(step['p']):.4g} MPa" in seen["shown"], f"the tip of the most pressed cell says {seen['shown']}")
    expect(seen["tactels"] == 24 * seen["steps"] and seen["path"] == 5, f"{seen['tactels']} rows of tactels, {seen['path']} of the path")
    # The script turns cells to the pad, the program their corners: the same cells with the same pressure.
    quads = check_vtu.read(vtu)
    for row, quad in zip(seen["rows"], quads):
        middle = [sum(corner[axis] for corner in quad["corners"]) / 4 for axis in (0, 1)]
        expect(abs(row[0] - middle[0]) + abs(row[1] - middle[1]) < 1e-4, f"a cell at {row[:2]} on the page and at {middle} in the VTU file")
        expect(abs(row[2] - quad["normal_traction"]) <= 1e-4 * abs(row[2]), f"a cell with p = {row[2]} on the page and {quad['normal_traction']} in the VTU file")
    expect(len(seen["rows"]) == len(quads) == 144, f"{len(quads)} cells in the VTU file")
    for problem in check_vtu.problems(quads, thickness=2.0):
        expect(False, "VTU: " + problem)
    browser.run("(() => { const s = document.querySelector('figure[data-kind=\"pad\"] input'); s.value = 0; s.dispatchEvent(new Event('input')); })()")
    empty = browser.run("document.querySelector('figure[data-kind=\"pad\"] .readout').textContent")
    expect("S, slip index–" in empty, f"a step without contact reads {empty}")


def check(path, sample, problems, vtu=None):
    def expect(good, problem):
        if not good:
            problems.append(problem)

    size = os.path.getsize(path)
    expect(size < LARGEST_PAGE, f"{size} bytes, {LARGEST_PAGE} at most")
    with Browser() as browser:
        check_layout(browser, path, expect)
        sliders = check_slider(browser, path, expect)
        if sample:
            expect(sliders == 2, f"{sliders} sliders instead of 2")
            check_known_numbers(browser, path, expect)
            check_pad(browser, path, expect, vtu)
        expect(len(browser.pdf()) > 10_000, "the page does not print")
        problems += [f"console: {text}" for text in browser.problems]
        problems += [f"requests {url}" for url in set(browser.requests) if not url.startswith(("file:", "data:", "blob:"))]


def main(argument):
    problems = []
    if argument.endswith(".html"):
        check(argument, False, problems)
    else:
        with tempfile.TemporaryDirectory() as folder:
            path, vtu = pathlib.Path(folder) / "sample.html", pathlib.Path(folder) / "sample.vtu"
            subprocess.run([argument, path, vtu], check=True)
            check(path, True, problems, vtu)
    print("\n".join(problems) or "no problem")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
