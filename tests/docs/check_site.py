# SPDX-License-Identifier: Apache-2.0
"""Checks the documentation site in a browser, from the file that scripts/site names: the search answers, texts can be
read, no page is wider than a telephone, no code is cut, copy buttons copy commands, the reference of the headers has a start page; and
its texts for language models: llms.txt and the pages as .md. Usage: check_site.py SITE"""
import json
import pathlib
import re
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "host/figures"))
from browser import Browser  # noqa: E402

REPOSITORY = pathlib.Path(__file__).resolve().parent.parent.parent
OF_HEADERS = ("index", "annotated", "files", "classtactel_1_1SlipEstimator", "solve_8h", "solve_8h_source")


CUT_CODE = """[...document.querySelectorAll('.md-content pre > code')].filter(code => code.scrollWidth > code.clientWidth).map(code => code.innerText.slice(0, 40))"""


def check_code(browser, where, expect):
    cut = browser.run(CUT_CODE)
    expect(not cut, f"{where}: code is cut at the right: {cut}")


def check_phone(browser, where, expect):
    scroll = browser.run("document.documentElement.scrollWidth")
    expect(scroll <= 390, f"{where}: {scroll} pixels wide")
    for text in browser.faint_texts():
        expect(False, f"{where}: {text}")


def switch_to_dark(browser, where, expect):
    """As a reader of the manual does; pages of the reference follow the system."""
    shown = "getComputedStyle(document.body).backgroundColor + getComputedStyle(document.documentElement).filter"
    light = browser.run(shown)
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    browser.run("document.querySelector('#__palette_2')?.click()")
    expect(browser.run(shown) != light, f"{where}: dark is as light is")


def check_search(browser, site, expect):
    """On a telephone, light and dark: the page that has a word, and results that can be read."""
    browser.open(site / "index.html", width=390)
    deadline = time.monotonic() + 60
    while browser.run("document.querySelector('.md-search-result__meta').innerText").startswith("Initializing") and time.monotonic() < deadline:
        time.sleep(0.1)
    browser.run("document.querySelector('label[for=__search]').click()")
    browser.run("(box => { box.focus(); box.value = 'conformal'; box.dispatchEvent(new Event('keyup', {bubbles: true})); })(document.querySelector('.md-search__input'))")
    found = []
    while not found and time.monotonic() < deadline:
        time.sleep(0.1)
        found = browser.run("[...document.querySelectorAll('.md-search-result__link')].map(a => a.href)")
    expect(any("bounds.html" in link for link in found), f"the search for a word of bounds.md finds {found}")
    browser.run("document.querySelectorAll('.md-search-result details').forEach(more => more.open = true)")

    def check_locked(where):
        while browser.run("document.documentElement.scrollWidth") > 390 and time.monotonic() < deadline:  # the page is locked late
            time.sleep(0.1)
        check_phone(browser, where, expect)

    check_locked("search, light")
    switch_to_dark(browser, "search", expect)
    check_locked("search, dark")


# Each page opened from a file has its search index made, which takes longer than all that is looked at here.
NO_SEARCH = "globalThis.Worker = class extends EventTarget { postMessage() {} terminate() {} }"


def check_looks(browser, site, expect):
    """Every page of the manual, and one of each kind of the reference, on a telephone: light and dark."""
    for page in sorted(set(site.glob("*.html")) - {site / "404.html"}) + [site / f"api/{name}.html" for name in OF_HEADERS] + sorted(site.glob("tutorials/*.html")):
        where = str(page.relative_to(site))
        browser.run("localStorage.clear()")  # else the site keeps the last scheme
        browser.open(page, width=390)
        check_phone(browser, f"{where}, light", expect)
        check_code(browser, where, expect)
        switch_to_dark(browser, where, expect)
        check_phone(browser, f"{where}, dark", expect)
        browser.call("Emulation.setDeviceMetricsOverride", width=1280, height=900, deviceScaleFactor=1, mobile=False)
        check_code(browser, f"{where}, 1280 pixels", expect)


def check_front(browser, site, expect):
    """The front page is README.md, with its pictures, in the scheme of the page; the gallery's can be read on a desk."""
    headings = re.findall(r"^## (.*)$", (REPOSITORY / "README.md").read_text(), re.M)
    for dark in (False, True):
        browser.run("localStorage.clear()")
        browser.open(site / "index.html", dark=dark)
        shown = browser.run("[...document.querySelectorAll('h2')].map(h => h.firstChild.data)")
        expect(shown == headings, f"index.html has {shown}, README.md {headings}")
        pictures = browser.run("[...document.querySelectorAll('.md-content img')].map(i => [getComputedStyle(i).content, i.naturalWidth])")
        expect(len(pictures) == 2 and all(width > 500 and ("-dark" in content) == dark for content, width in pictures), f"pictures of index.html: {pictures}")
    browser.open(site / "gallery.html")
    widths = browser.run("[...document.querySelectorAll('.gallery img')].map(i => i.clientWidth)")
    expect(len(widths) == 8 and min(widths) >= 0.6 * 820, f"pictures of 820 pixels in the gallery are {widths} wide")  # 12 pixels of text are 7


def check_texts(site, expect):
    """Each page is beside itself as .md; llms.txt leads to those of the menu, and each of its links somewhere."""
    pages = [path for folder in (".", "tutorials", "notebook") for path in site.glob(f"{folder}/*.html") if path.name != "404.html"]
    for page in pages:
        text = page.with_suffix(".md").read_text() if page.with_suffix(".md").exists() else ""
        expect(text.startswith("# ") and "<!-- test" not in text, f"{page.relative_to(site)} has no .md beside it, or one with comments of tests")
    text = (site / "llms.txt").read_text()
    linked = re.findall(r"^- \[.+\]\((.+\.md)\): \S.*$", text, re.M)
    expect(text.startswith("# tactel\n\n> ") and text.count("\n- ") == len(linked), f"llms.txt: {text[:200]!r}")
    expect(set(linked) == {str(page.relative_to(site).with_suffix(".md")) for page in pages if page.parent.name != "notebook"} | {"notebook/index.md"},
           f"llms.txt leads to {linked}")


def check_copy(browser, site, expect):
    def copied(page, block, text=None):
        browser.open(site / page, height=20_000)  # a block has its button once it is in sight
        button = f"[...document.querySelectorAll('.md-clipboard')].find(b => document.querySelector(b.dataset.clipboardTarget).innerText.startsWith({block!r}))"
        deadline = time.monotonic() + 30
        while not browser.run(f"{button} !== undefined") and time.monotonic() < deadline:
            time.sleep(0.1)
        if text:
            browser.run(f"document.querySelector({button}.dataset.clipboardTarget).innerText = {json.dumps(text)}")
        return (browser.run(f"(b => {{ b.click(); return b.dataset.clipboardText; }})({button})") or "").split("\n")

    lines = copied("networks.html", "$ build/tactel generate examples/paper")  # three commands, their output, and a fourth
    expect(len(lines) == 4 and all(line.startswith("build/tactel ") for line in lines), f"a button copies {lines}")
    lines = copied("ros.html", "$ printf", "$ printf '{a: 1,\\\n b: 2}'\na: 1")  # one on two lines, which no page has now, and its output
    expect(lines == ["printf '{a: 1,\\", " b: 2}'"], f"a button copies {lines}")


def main(site):
    problems = []

    def expect(good, problem):
        if not good:
            problems.append(problem)

    with Browser() as browser:
        check_search(browser, site, expect)
        browser.call("Page.addScriptToEvaluateOnNewDocument", source=NO_SEARCH)
        check_looks(browser, site, expect)
        check_front(browser, site, expect)
        check_texts(site, expect)
        check_copy(browser, site, expect)
        browser.open(site / "reference.html")
        expect(browser.run("document.querySelector('a[href=\"#slipestimator\"]') && document.querySelector('#slipestimator ~ ul').innerText.includes('Returns the upper bound of S')"),
               "reference.html does not lead to SlipEstimator.upper and its text")
        helps = browser.run("[...document.querySelectorAll('pre')].map(block => block.innerText).join()")
        expect(all(option in helps for option in ("--friction-drift", "--momentum", "--walkers")), "reference.html lacks the help of tactel monitor, tactel train or tactel.floor")
        browser.open(site / "api/index.html")
        start, example = (browser.run(f"document.querySelector('{part}').innerText") for part in (".contents", ".fragment"))
        expect("SlipEstimator" in start and "tactel/solve.h" in start, f"api/index.html begins with {start[:100]!r}")
        compiled = (REPOSITORY / "docs/cpp.md").read_text()  # install.snippets
        unknown = [line for line in example.split("\n") if line.strip() not in compiled]
        expect(len(example) > 300 and not unknown, f"lines of the example that docs/cpp.md does not have: {unknown}")
        problems += [f"console: {text}" for text in browser.problems]
        problems += [f"requests {url}" for url in set(browser.requests) if not url.startswith(("file:", "data:", "blob:"))]
    print("\n".join(problems))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
