# SPDX-License-Identifier: Apache-2.0
"""Runs the fenced blocks of a page one after the other, in a fresh folder, as a reader would who copies them.

Usage: run_blocks.py PAGE [--nightly] [--root TREE] [--build TREE] [--prefix INSTALLED]
The folder holds examples/ (sweeps of 300 contacts), docs/ and links to build/ and tests/; it is gone afterwards.

| language | what is done |
|---|---|
| none, sh | run by bash; where lines begin with "$ ", those alone |
| python | run by this Python; all blocks of a page share their names |
| toml | a scene, completed where it is a part of one, is solved; a device profile is read, of lines with a line |
| cpp, c, cmake | a block whose first line names a file is written; CMake lines alone are configured |
| text, json | shown only |

A comment in the line above a block says where its run differs:
  <!-- test: skip, REASON -->       not run; the reason is printed
  <!-- test: nightly, REASON -->    run with --nightly alone; else the files that it names are looked for
  <!-- test: first, COMMAND -->     makes what the reader has
  <!-- test: 10000000 -> 3000 -->   a smaller size
Ends with 1 at the first block that fails, as PAGE:LINE."""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

CONTACTS = 300
BLOCK = re.compile(r"((?:^<!-- test: [^\n]* -->\n)*)^```(\w*)\n(.*?)^```$", re.M | re.S)
PART_OF_A_SCENE = {"indenter": '\n[indenter]\nshape = "parabola"\nradius = 10.0\n', "load": "\n[load]\nindentation = 0.1\n"}
NO_SUCH_DEVICE = 3


class Failed(Exception):
    """A block did not do what it says."""


class Page:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.names = {"__name__": "__main__"}
        paths = [str(folder / "bin"), "/usr/bin", os.environ["PATH"]]
        libraries = next(options.prefix.glob("lib*/**/libtactel_infer.so"), options.prefix / "lib/none").parent
        self.environment = {**os.environ, "PATH": ":".join(paths), "PKG_CONFIG_PATH": str(libraries / "pkgconfig"),
                            "LD_LIBRARY_PATH": str(libraries), "CMAKE_PREFIX_PATH": str(options.prefix), "MPLBACKEND": "agg",
                            "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}

    def shell(self, script, expected=0):
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=self.folder, env=self.environment,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode != expected:
            raise Failed(f"ended with {done.returncode}:\n{script}\n{done.stdout[-3000:]}")

    def require_files(self, text):
        """What a block that is not run names in the reader's folders is there."""
        for name in re.findall(r"(?<![\w/])(?:build|studies|tests|examples)/[\w./-]*\w", text):
            if not (self.folder / name).exists():
                raise Failed(f"{name}: no such file")

    def run_sh(self, text, _line):
        shown = re.findall(r"^\$ ((?:.*\\\n)*.*)$", text, re.M)
        self.shell("\n".join(shown) if shown else text)

    def run_python(self, text, line):
        try:
            exec(compile("\n" * line + text, self.options.page.name, "exec"), self.names)
        except Exception as error:
            raise Failed(f"{type(error).__name__}: {error}") from error

    def run_toml(self, text, _line):
        if channels := re.search(r'^kind = "csv"\nchannels = (\d+)', text, re.M):
            (self.folder / "profile.toml").write_text(text)
            self.shell(f"seq -s, 2 {int(channels[1]) + 1} | tactel record --source csv:- --profile profile.toml --output lines.rec --force")
            return
        if "[device]" in text:
            (self.folder / "profile.toml").write_text(text)
            self.shell("tactel record --source usb:1209:0001 --profile profile.toml --output none.rec", NO_SUCH_DEVICE)
            return
        parts = "".join(part for table, part in PART_OF_A_SCENE.items() if f"[{table}]" not in text)
        (self.folder / "scene.toml").write_text(text + parts)
        self.shell("tactel solve scene.toml")

    def write_source(self, text, _line):
        named = re.match(r"(?:#|//|/\*) ([\w./]+\.\w+)\b", text)
        if not named:
            raise Failed("its first line names no file")
        path = self.folder / named[1]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def run_cmake(self, text, line):
        if "project(" in text:
            self.write_source(text, line)
            return
        project = self.folder / f"cmake_{line}"
        project.mkdir()
        target = re.search(r"target_link_libraries\((\w+)", text)[1]
        head = f"cmake_minimum_required(VERSION 3.16)\nproject(part LANGUAGES C CXX)\nadd_executable({target} main.cpp)\n"
        (project / "main.cpp").write_text("#include <tactel/infer.h>\nint main() { return 0; }\n")
        (project / "CMakeLists.txt").write_text(head + text)
        self.shell(f"cmake -S {project.name} -B {project.name}/build && cmake --build {project.name}/build")

    def run(self, language, text, line):
        runs = {"": self.run_sh, "sh": self.run_sh, "python": self.run_python, "toml": self.run_toml, "cmake": self.run_cmake,
                "cpp": self.write_source, "c": self.write_source, "text": None, "json": None}
        if language not in runs:
            raise Failed(f"{language}: no such language")
        if runs[language]:
            runs[language](text, line)


def smaller_examples(source, to):
    to.mkdir()
    for path in source.iterdir():
        if path.suffix in (".toml", ".csv"):
            shown = re.sub(r"^contacts = \d+", f"contacts = {CONTACTS}", path.read_text(), flags=re.M)
            (to / path.name).write_text(shown)


def prepare(folder, options):
    smaller_examples(options.root / "examples", folder / "examples")
    (folder / "build").symlink_to(options.build)
    for drawn in ("docs", "studies"):  # scripts draw beside themselves
        shutil.copytree(options.root / drawn, folder / drawn)
    (folder / "tests").symlink_to(options.root / "tests")
    (folder / "bin").mkdir()
    (folder / "bin/tactel").symlink_to(options.build / "tactel")


def run_block(page, markers, language, text, line):
    """Returns why the block was not run, or None."""
    for marker in markers:
        word, comma, rest = marker.partition(", ")
        old, arrow, new = marker.partition(" -> ")
        if comma and word == "skip":
            return rest
        if comma and word == "nightly":
            if not page.options.nightly:
                page.require_files(text)
                return f"nightly, {rest}"
        elif comma and word == "first":
            page.shell(rest)
        elif arrow:
            if old not in text:
                raise Failed(f"{old} is not in this block")
            text = text.replace(old, new)
        else:
            raise Failed(f"test: {marker}: skip, nightly, first or OLD -> NEW")
    page.run(language, text, line)
    return None


def run_page(options):
    text = options.page.read_text()
    name = options.page.relative_to(options.root) if options.page.is_relative_to(options.root) else options.page.name
    if text.count("```") != 2 * len(list(BLOCK.finditer(text))):
        sys.exit(f"{name}: a block is not closed, or does not begin a line")
    with tempfile.TemporaryDirectory() as folder:
        page = Page(options, pathlib.Path(folder))
        prepare(page.folder, options)
        os.chdir(folder)
        for block in BLOCK.finditer(text):
            markers = re.findall(r"<!-- test: (.*) -->", block[1])
            line = text.count("\n", 0, block.start(3))
            try:
                reason = run_block(page, markers, block[2], block[3], line)
            except Failed as failure:
                sys.exit(f"{name}:{line}: {failure}")
            if reason:
                print(f"{name}:{line}: not run: {reason}")
        os.chdir(options.root)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("page", type=lambda p: pathlib.Path(p).resolve())
    parser.add_argument("--nightly", action="store_true")
    root = pathlib.Path(__file__).resolve().parents[2]
    parser.add_argument("--root", type=pathlib.Path, default=root)
    parser.add_argument("--build", type=pathlib.Path, default=root / "build")
    parser.add_argument("--prefix", type=pathlib.Path, default=root / "build/api/prefix")
    run_page(parser.parse_args())


if __name__ == "__main__":
    main()
