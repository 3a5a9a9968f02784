# SPDX-License-Identifier: Apache-2.0
"""What packages say and start, without a build: python3 -m unittest discover -s tests/package."""
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
