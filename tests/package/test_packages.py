# SPDX-License-Identifier: Apache-2.0
"""What packages say and start, without a build: python3 -m unittest discover -s tests/package."""
import ast
import os
import pathlib
import re
import runpy
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).parents[2]
PYTHON = ROOT / "host/python"
VERSION = re.search(r"\nversion: (\S+)\n", (ROOT / "CITATION.cff").read_text())[1]


def text(name):
    return (ROOT / name).read_text()


class Metadata(unittest.TestCase):
    def test_all_name_one_version(self):
        number, candidate = re.search(r"project\(tactel VERSION ([0-9.]+).*?set\(TACTEL_VERSION \S+?(-rc[0-9]+)?\)",
                                      text("CMakeLists.txt"), re.S).groups(default="")
        self.assertIn(f"\nversion: {number}{candidate}\n", text("CITATION.cff"))
        rule = re.search(r"regex = '(.*)'\nresult = \"(.*)\"", text("pyproject.toml"))
        found = re.search(rule[1], text("CMakeLists.txt")).groupdict()
        self.assertEqual(rule[2].format(**found), number + candidate.replace("-", ""))

    def test_the_maintainer_is_the_author(self):
        name = re.search(r'authors:\n  - name: "(.*)"', text("CITATION.cff"))[1]
        contact = re.search(r'CPACK_PACKAGE_CONTACT "(.*) <(.*)>"', text("cmake/packages.cmake"))
        self.assertEqual(contact[1], name)
        self.assertNotIn("localhost", contact[2])
        self.assertIn(f'authors = [{{ name = "{name}" }}]', text("pyproject.toml"))

    def test_an_unknown_package_is_refused(self):
        done = subprocess.run([ROOT / "scripts/package", "rpm"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn("deb | wheel", done.stderr)

    def test_files_in_packages_have_the_date_of_the_commit(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name in ("scripts", "build-package", "bin"):
                (root / name).mkdir()
            for name in ("scripts/package", "scripts/steps.sh"):
                (root / name).write_text(text(name))
            (root / "build-package/a.deb").touch()
            for name in ("cmake", "cpack", "help2man", "dpkg-shlibdeps", "mpicc"):
                (root / "bin" / name).write_text(f'#!/bin/sh\necho {name} $SOURCE_DATE_EPOCH >> "{root}/dates"; touch a.deb\n')
                (root / "bin" / name).chmod(0o755)
            env = {**os.environ, "PATH": f"{root}/bin:{os.environ['PATH']}", "GIT_COMMITTER_DATE": "1700000000 +0000"}
            env.pop("SOURCE_DATE_EPOCH", None)
            for words in (["init", "-q"], ["-c", "user.name=a", "-c", "user.email=a@b", "commit", "-q", "--allow-empty", "-m", "all"]):
                subprocess.run(["git", "-C", folder, *words], check=True, env=env)
            for given, date in (({}, "1700000000"), ({"SOURCE_DATE_EPOCH": "5"}, "5")):
                (root / "dates").unlink(missing_ok=True)
                subprocess.run(["bash", root / "scripts/package"], check=True, capture_output=True, env={**env, **given})
                self.assertEqual((root / "dates").read_text(), f"cmake {date}\n" * 2 + f"cpack {date}\n")

    def test_an_interpreter_without_numpy_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            bare = pathlib.Path(folder) / "python"
            bare.write_text("#!/bin/sh\nexit 1\n")
            bare.chmod(0o755)
            ask = [["cmake", f"-DPython_EXECUTABLE={python}", "-P", ROOT / "cmake/expect_numpy.cmake"] for python in (bare, sys.executable)]
            without, has = (subprocess.run(words, capture_output=True, text=True) for words in ask)
            self.assertIn(f"{bare} has no NumPy", " ".join(without.stderr.split()))
            self.assertEqual((without.returncode != 0, has.returncode), (True, 0))


class Release(unittest.TestCase):
    """scripts/release in a repository of its own, which has its scripts and what names the version."""

    def repository(self, folder, changelog, more=()):
        root = pathlib.Path(folder)
        (root / "scripts").mkdir()
        for name in ("scripts/release", "scripts/steps.sh", "CMakeLists.txt"):
            (root / name).write_text(text(name))
        (root / "CHANGELOG.md").write_text(changelog)
        programs = {f"python3.{minor}": f"echo python3.{minor}" for minor in range(9, 16)}
        programs |= {"python3.12": "exit 1", "scripts/package": "mkdir -p build-package; touch build-package/a.deb; echo made $@ >&2; [ $1 = deb ]"}
        for program, does in programs.items():
            (root / program).write_text(f"#!/bin/sh\n{does}\n")
            (root / program).chmod(0o755)
        git = ["git", "-c", "user.name=a", "-c", "user.email=a@b", "-C", folder]
        for words in (["init", "-q"], ["add", "-A"], ["commit", "-qm", "all"], *more):
            subprocess.run([*git, *words], check=True)
        return root

    def test_interpreters_that_run_get_wheels(self):
        with tempfile.TemporaryDirectory() as folder:
            root = self.repository(folder, f"## {VERSION}\n\n- all of it\n")
            done = subprocess.run(["bash", root / "scripts/release"], capture_output=True, text=True,
                                  env={**os.environ, "PATH": f"{root}:{os.environ['PATH']}"})
            self.assertIn("no python3.12 with pip: no wheel for it\nmade deb\n", done.stderr)
            self.assertIn(f"made wheel {' '.join(f'python3.{minor}' for minor in (9, 10, 11, 13, 14, 15))}\n", done.stderr)

    def refusal(self, changelog, **then):
        with tempfile.TemporaryDirectory() as folder:
            root = self.repository(folder, changelog, then.get("git", ()))
            if "file" in then:
                (root / then["file"]).write_text("")
            done = subprocess.run(["bash", root / "scripts/release"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertFalse((root / "build-release").exists())
            return done.stderr

    def test_what_is_no_release_is_refused(self):
        notes = f"## {VERSION}\n\n- all of it\n"
        self.assertIn("the tree has changes", self.refusal(notes, file="new.txt"))
        self.assertIn(f'no section "## {VERSION}"', self.refusal("## 0.9.0\n\n- less\n"))
        tag = ["tag", f"v{VERSION}"], ["commit", "-q", "--allow-empty", "-m", "more"]
        self.assertIn(f"the tag v{VERSION} names another commit", self.refusal(notes, git=tag))


class Sources(unittest.TestCase):
    def test_the_first_python_of_wheels_reads_them(self):
        """What needs a newer one than pyproject.toml names: syntax, and a | b in an annotation that is evaluated."""
        first = tuple(map(int, re.search(r'requires-python = ">=(\d+)[.](\d+)"', text("pyproject.toml")).groups()))
        sources = [*PYTHON.rglob("*.py"), *(ROOT / "examples").rglob("*.py")]
        for path in sources:
            tree = ast.parse(path.read_text(), feature_version=first)
            late = any(isinstance(node, ast.ImportFrom) and node.module == "__future__" for node in tree.body)
            notes = [note for node in ast.walk(tree) for note in (getattr(node, "annotation", None), getattr(node, "returns", None)) if note]
            unions = [note.lineno for note in notes for part in ast.walk(note) if isinstance(part, ast.BinOp)]
            self.assertTrue(late or not unions or first >= (3, 10), f"{path}:{unions}: from __future__ import annotations")
        self.assertGreater(len(sources), 20)


class Wheel(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.prefix = pathlib.Path(folder.name)
        self.driver = self.prefix / "lib/libintelocl.so"
        self.driver.parent.mkdir()
        self.driver.touch()

    def named(self, system, **environment):
        """The driver that is named beside those of the system."""
        with mock.patch("sys.prefix", str(self.prefix)), mock.patch("glob.glob", lambda pattern: system), \
                mock.patch.dict(os.environ, environment, clear=True):
            runpy.run_path(str(PYTHON / "tactel/_driver.py"))
            return os.environ.get("OCL_ICD_VENDORS")

    def test_the_driver_of_the_environment_is_named(self):
        self.assertEqual(self.named([]), str(self.driver))

    def test_those_of_system_and_user_come_first(self):
        self.assertIsNone(self.named(["/etc/OpenCL/vendors/pocl.icd"]))
        self.assertEqual(self.named([], OCL_ICD_VENDORS="mine"), "mine")

    def test_no_driver_no_name(self):
        self.driver.unlink()
        self.assertIsNone(self.named([]))

    def test_the_command_runs_the_program_of_the_package(self):
        package = self.prefix / "site/tactel"
        package.mkdir(parents=True)
        (package / "__init__.py").write_text("raise ImportError('the command loads the package')")
        (package / "_driver.py").write_text((PYTHON / "tactel/_driver.py").read_text())
        (package / "tactel").write_text("#!/bin/sh\necho \"$@\"\nexit 4\n")
        (package / "tactel").chmod(0o755)
        command = self.prefix / "tactel"
        command.write_text((PYTHON / "program.py").read_text())
        done = subprocess.run([sys.executable, command, "solve", "a b"], capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(package.parent)})
        self.assertEqual((done.stdout, done.returncode), ("solve a b\n", 4), done.stderr)


if __name__ == "__main__":
    unittest.main()
