# SPDX-License-Identifier: Apache-2.0
"""Checks Markdown: links and named files exist, commands and options are those of the program, lines hold 100 columns,
tables have a head; and that the manual is short and speaks of the present.

Usage: check_markdown.py ROOT [TACTEL] [--lines 250] [--words 18000]
Checks every *.md under ROOT. With TACTEL, the program, also each `tactel COMMAND --option` of code and code blocks.
The manual is README.md and docs/*.md: pages of at most so many lines, docs/*.md but TUTORIALS of so many words (as `wc -w`), no word of
PAST in a sentence, heading or table (code and comments are none).
Pages of docs/notebook are dated and keep the commands and files of their day: their links and lines are checked.
Prints every problem as FILE:LINE: problem; ends with 1 where there is one."""
import argparse
import pathlib
import re
import subprocess
import sys

FOLDERS = ("bench", "docs", "examples", "fem", "host", "hw", "kernels", "nn", "scripts", "studies", "tests")
PLACEHOLDER = re.compile(r"[A-Z]{3,}|\.\.\.")  # host/ROOM/NAME.h
WIDEST = 100
TUTORIALS = ("from-sensor-to-alarm.md", "pad-to-alarm.md")
PAST = re.compile(r"\b(before|now|nowadays|was|were|wasn't|weren't|formerly|previously|no longer|used to|until now|so far|"
                  r"earlier version|in the past|aims?)\b", re.I)


def lines_with_kind(text):
    """Yields (number, line, kind): "fence", "code" (a block), "table" or "text"."""
    fenced = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            fenced = not fenced
            yield number, line, "fence"
        elif fenced or line.startswith("    "):
            yield number, line, "code"
        else:
            yield number, line, "table" if line.startswith("|") else "text"


def exists(name, near, root):
    """A file or folder, or a pattern that some file matches, beside the document or from the root on."""
    return any(base.joinpath(name).exists() or ("*" in name and any(base.glob(name))) for base in (near, root))


def anchors(page):
    """Of headings, as the site and GitHub name them."""
    headings = [line.lstrip("# ") for _, line, kind in lines_with_kind(page.read_text()) if kind == "text" and line.startswith("#")]
    return {re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", heading).strip().lower()) for heading in headings}


def missing_files(line, near, root, sources):
    """Names with a folder of the tree or beside the document; and sources without a folder, which may be anywhere."""
    for name in re.findall(r"`([\w./*-]+)`", line):
        if PLACEHOLDER.search(name):
            continue
        first, slash, _ = name.partition("/")
        if slash and first and (first in FOLDERS or near.joinpath(first).is_dir()):
            if not exists(name, near, root):
                yield name
        elif not slash and re.fullmatch(r"[a-z]\w*\.(h|cpp|cl)", name) and name not in sources:
            yield name


class Program:
    """Commands and options of the program, from its --help."""

    def __init__(self, path):
        self.path = path
        self.commands = {"help", *re.findall(r"^  ([a-z-]+)  ", self.help(), re.M)}
        self.options = {"help": set()}

    def help(self, *command):
        return subprocess.run([self.path, *command, "--help"], check=True, capture_output=True, text=True).stdout

    def problems(self, code):
        for command, rest in re.findall(r"(?:^|[/ `])tactel ([a-z][a-z-]*)\b([^`#|;&]*)", code):
            if command not in self.commands:
                yield f"tactel {command}: no such command"
                continue
            if command not in self.options:
                text = self.help(command)
                text += "".join(self.help(command, word) for word in re.findall(r"^  ([a-z-]+)  ", text, re.M)
                                if "[OPTIONS] COMMAND" in text)
                self.options[command] = set(re.findall(r"--[a-z][a-z0-9-]*", text))
            for option in re.findall(r"(?<![\w-])--[a-z][a-z0-9-]*", rest):
                if option not in self.options[command]:
                    yield f"tactel {command} {option}: no such option"


def code_of(line, kind):
    return [line] if kind == "code" else re.findall(r"`([^`]*)`", line)


def manual(root):
    return [path for path in [root / "README.md", *sorted(root.glob("docs/*.md"))] if path.exists()]


def sentences(line):
    """What a reader reads as language: no code, formula, comment or target of a link."""
    return re.sub(r"`[^`]*`|\$[^$]*\$|<!--.*?-->|\]\([^)]*\)", " ", line)


def too_long(root, most_lines, most_words):
    words = 0
    for path in manual(root):
        text = path.read_text()
        words += len(text.split()) if path.name not in ("README.md", *TUTORIALS) else 0
        if text.count("\n") > most_lines:
            yield f"{path.relative_to(root)}:{most_lines + 1}: {text.count(chr(10))} lines, {most_lines} at most; measurements belong to docs/notebook"
    if words > most_words:
        yield f"docs:1: the manual has {words} words, {most_words} at most; measurements belong to docs/notebook"


def problems(path, root, sources, program):
    dated = "notebook" in path.parts
    if dated:
        program = None
    of_manual = path in manual(root)
    lines = path.read_text().splitlines()
    before = ""
    for number, line, kind in lines_with_kind("\n".join(lines)):
        found = []
        if line.startswith("| ") and kind == "table" and before != "table" and not "".join(lines[number:number + 1]).startswith("|--"):
            found.append("rows of a table without its head")
        before = kind
        if kind == "text" and len(line) > WIDEST and not line.startswith("!["):
            found.append(f"{len(line)} columns, {WIDEST} at most")
        if kind in ("text", "table"):
            for link, anchor in re.findall(r"\]\(([^)#]*)#?([^)]*)\)", re.sub(r"`[^`]*`", "", line)):
                target = path.parent / link if link else path
                if "://" in link:
                    continue
                if not target.exists():
                    found.append(f"link to {link}: no such file")
                elif anchor and target.suffix == ".md" and anchor not in anchors(target):
                    found.append(f"link to {link}#{anchor}: no such heading")
            if not dated:
                found += [f"{name}: no such file" for name in missing_files(line, path.parent, root, sources)]
            if of_manual:
                found += [f"\"{word[0]}\": the manual speaks of the present" for word in PAST.finditer(sentences(line))]
        if program and kind != "fence":
            for code in code_of(line, kind):
                found += program.problems(code)
        for problem in found:
            yield f"{path.relative_to(root)}:{number}: {problem}"


def documents(root):
    """Every *.md outside of build trees, hidden folders and the deliberate mistakes of this test."""
    for entry in sorted(root.iterdir()):
        if entry.is_dir() and not entry.name.startswith(("build", ".")):
            yield from (p for p in sorted(entry.rglob("*.md")) if not p.is_relative_to(root / "tests/docs/wrong"))
        elif entry.suffix == ".md":
            yield entry


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("root", type=lambda p: pathlib.Path(p).resolve())
    parser.add_argument("tactel", nargs="?")
    parser.add_argument("--lines", type=int, default=250)
    parser.add_argument("--words", type=int, default=18000)
    options = parser.parse_args()
    program = Program(options.tactel) if options.tactel else None
    sources = {path.name for folder in FOLDERS for path in options.root.joinpath(folder).rglob("*")}
    found = [problem for path in documents(options.root) for problem in problems(path, options.root, sources, program)]
    found += too_long(options.root, options.lines, options.words)
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
