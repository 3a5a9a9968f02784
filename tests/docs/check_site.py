# SPDX-License-Identifier: Apache-2.0
"""Checks the documentation site in a browser, from the file that scripts/site names: the search answers, links can be
read, copy buttons copy commands, the reference of the headers has a start page. Usage: check_site.py SITE"""
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "host/figures"))
from browser import Browser  # noqa: E402

LEAST_CONTRAST = 4.5  # WCAG 2.1, 1.4.3

# Contrast of an element's colour over the first opaque background around it, by WCAG 2.1.
CONTRAST = """(element => {
  const numbers = colour => colour.match(/[\\d.]+/g).map(Number);
  const luminance = ([r, g, b]) => [r, g, b].map(v => v / 255).map(v => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  let behind = element;
  while (behind && [0].includes(numbers(getComputedStyle(behind).backgroundColor)[3])) behind = behind.parentElement;
  const two = [getComputedStyle(element).color, behind ? getComputedStyle(behind).backgroundColor : "rgb(255, 255, 255)"]
    .map(numbers).map(luminance).sort((a, b) => b - a);
  return (two[0] + 0.05) / (two[1] + 0.05);
})"""


def check_search(browser, site, expect):
    browser.open(site / "index.html")
    deadline = time.monotonic() + 30
    while browser.run("document.querySelector('.md-search-result__meta').innerText").startswith("Initializing") and time.monotonic() < deadline:
        time.sleep(0.1)
    browser.run("(box => { box.focus(); box.value = 'conformal'; box.dispatchEvent(new Event('keyup', {bubbles: true})); })(document.querySelector('.md-search__input'))")
    found = []
    while not found and time.monotonic() < deadline:
        time.sleep(0.1)
        found = browser.run("[...document.querySelectorAll('.md-search-result__link')].map(a => a.href)")
    expect(any("networks.html" in link for link in found), f"the search for a word of networks.md finds {found}")


def check_contrast(browser, site, expect):
    for page, selector in (("index.html", ".md-content a"), ("index.html", ".md-header__title"), ("api/index.html", ".contents a")):
        for dark in (False, True):
            browser.open(site / page)
            browser.run("document.head.append(Object.assign(document.createElement('style'), {textContent: '* { transition: none !important }'}))")
            browser.run(f"if (document.body.dataset.mdColorScheme) document.body.dataset.mdColorScheme = '{'slate' if dark else 'default'}'")
            least = browser.run(f"Math.min(...[...document.querySelectorAll('{selector}')].filter(a => a.innerText.trim() && !a.matches('.headerlink')).map({CONTRAST}))")
            expect(least is not None and least >= LEAST_CONTRAST, f"{page}, dark {dark}: {selector} has a contrast of {least}")


def check_copy(browser, site, expect):
    """The first block of networks.md: three commands, their output, and a fourth."""
    browser.open(site / "networks.html")
    while not browser.run("document.querySelector('.md-clipboard') !== null"):  # a script makes the buttons
        time.sleep(0.1)
    browser.run("document.querySelector('.md-clipboard').click()")
    copied = browser.run("document.querySelector('.md-clipboard').dataset.clipboardText")
    lines = (copied or "").split("\n")
    expect(len(lines) == 4 and all(line.startswith("build/tactel ") for line in lines), f"a button copies {copied!r}")


def main(site):
    problems = []

    def expect(good, problem):
        if not good:
            problems.append(problem)

    with Browser() as browser:
        check_search(browser, site, expect)
        check_contrast(browser, site, expect)
        check_copy(browser, site, expect)
        browser.open(site / "api/index.html")
        start = browser.run("document.querySelector('.contents').innerText")
        expect("SlipEstimator" in start and "tactel/solve.h" in start, f"api/index.html begins with {start[:100]!r}")
        problems += [f"console: {text}" for text in browser.problems]
        problems += [f"requests {url}" for url in set(browser.requests) if not url.startswith(("file:", "data:", "blob:"))]
    print("\n".join(problems))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
