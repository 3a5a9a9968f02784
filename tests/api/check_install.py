# SPDX-License-Identifier: Apache-2.0
"""Installs a build tree, and builds and runs programs outside of it with other options.

Usage: check_install.py STEP --build TREE --source TREE --prefix FOLDER [--cc C] [--cxx C++]
The step `install` comes first; the others use what it installed. Ends with 1 and a line for each finding."""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys

FLAGS = "-O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -D_GLIBCXX_ASSERTIONS -Wall -Wextra -Werror"
MOST_LINES = 30000
THIRD_PARTIES = re.compile(r"eigen3|/CL/|hdf5|toml\+\+|nlohmann|/fmt/|/CLI/|google/|onnx|libusb|xxhash|openmpi|/mpi")
PUBLIC_SYMBOL = re.compile(r"((typeinfo|typeinfo name|vtable) for )?tactel::(?!(host|fem|nn|hw|infer|api)::)|tactel_[a-z_]+$")
STANDARD_LIBRARIES = {"libstdc++.so.6", "libm.so.6", "libgcc_s.so.1", "libc.so.6", "ld-linux-x86-64.so.2"}
NETWORKS = ("seed", "seed_by_frame")


class Check:
    def __init__(self, options):
        self.build, self.source, self.prefix = options.build, options.source, options.prefix
        self.cc, self.cxx = options.cc, options.cxx
        self.work = self.prefix.parent / f"work_{options.step}"
        self.findings = []
        shutil.rmtree(self.work, ignore_errors=True)
        self.work.mkdir(parents=True)

    def expect(self, met, finding):
        if not met:
            self.findings.append(finding)

    def run(self, *command, env=None, cwd=None):
        """The output of a command that must end with 0."""
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, cwd=cwd,
                              env={**os.environ, **(env or {})})
        if done.returncode != 0:
            sys.exit(f"{' '.join(str(word) for word in command)} ended with {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout

    def lib(self):
        return next(self.prefix.glob("lib*/**/libtactel_infer.so")).parent

    def network(self, name):
        return self.source / "tests/fuzz/corpus/network" / name

    def configure(self, project, *options, flags=FLAGS):
        self.run("cmake", "-G", "Ninja", "-S", project, "-B", self.work / "tree", f"-DCMAKE_PREFIX_PATH={self.prefix}",
                 f"-DCMAKE_C_COMPILER={self.cc}", f"-DCMAKE_CXX_COMPILER={self.cxx}", f"-DCMAKE_C_FLAGS={flags}",
                 f"-DCMAKE_CXX_FLAGS={flags}", *options)
        return self.work / "tree"

    def compile(self, project, *options, flags=FLAGS):
        tree = self.configure(project, *options, flags=flags)
        self.run("cmake", "--build", tree, "--parallel", "2")
        return tree

    def answers(self, *programs):
        """All programs must say the same of every network; one may be a list, of what runs it and it."""
        for name in NETWORKS:
            said = {self.run(*(program if isinstance(program, list) else [program]), self.network(name), self.work / "none.onnx") for program in programs}
            self.expect(len(said) == 1 and re.fullmatch(r"\d+ inputs, S = 0\.\d+, ok\n", said.pop()),
                        f"{name}: answers differ, or are none")

    # The steps.

    def install(self):
        shutil.rmtree(self.prefix, ignore_errors=True)
        first = self.work / "prefix"
        self.run("cmake", "--install", self.build, "--prefix", first)
        first.rename(self.prefix)  # what is installed may be moved
        for name in ("bin/tactel", "include/tactel.h", "include/tactel/infer.h", "include/tactel/simulate.h",
                     "include/tactel/live.h", "lib*/**/libtactel_infer.so.1.0.0", "lib*/**/libtactel_simulate.so.1",
                     "lib*/**/cmake/tactel/tactel-config.cmake", "lib*/**/pkgconfig/tactel.pc",
                     "lib*/**/pkgconfig/tactel-simulate.pc", "lib/udev/rules.d/70-tactel.rules"):
            self.expect(any(self.prefix.glob(name)), f"{name} is not installed")
        for path in [*self.prefix.rglob("*.cmake"), *self.prefix.rglob("*.pc")]:
            for word in (str(self.source), str(self.build), str(first), "-march", "-Werror", "Eigen", "OpenCL"):
                self.expect(word not in path.read_text(), f"{path.name} contains {word}")
        self.expect("1.0" in self.run(self.prefix / "bin/tactel", "--version"), "the program says no version")

    def headers(self):
        include = self.prefix / "include"
        for path in sorted(include.rglob("*.h")):
            name = path.relative_to(include)
            source = self.work / "one.cpp"
            source.write_text(f"#include <{name}>\n#include <{name}>\n")
            command = [self.cxx, "-std=c++20", "-Wall", "-Wextra", "-Werror", "-pedantic", "-I", include]
            self.run(*command, "-fsyntax-only", "-MD", "-MF", self.work / "used", source)
            lines = [line for line in self.run(*command, "-E", "-P", source).splitlines() if line.strip()]
            self.expect(len(lines) < MOST_LINES, f"{name}: {len(lines)} preprocessed lines")
            for used in (self.work / "used").read_text().split()[1:]:
                self.expect(not THIRD_PARTIES.search(used), f"{name} includes {used}")
        plain = self.work / "one.c"
        plain.write_text("#include <tactel.h>\n")
        for standard in ("c99", "c11"):
            self.run(self.cc, f"-std={standard}", "-Wall", "-Wextra", "-Werror", "-pedantic", "-I", include, "-fsyntax-only", plain)

    def symbols(self):
        for component in ("infer", "simulate"):
            library = self.lib() / f"libtactel_{component}.so"
            shown = self.run("nm", "-DC", "--defined-only", library).splitlines()
            names = [line.split(" ", 2)[2] for line in shown]
            self.expect(len(names) > 10, f"{component} shows {len(names)} symbols")
            for name in names:
                self.expect(PUBLIC_SYMBOL.match(name), f"{component} shows {name}")
            dynamic = self.run("readelf", "-d", library)
            self.expect(f"soname: [libtactel_{component}.so.1]" in dynamic, f"{component} has no soname")
            self.expect(not re.search("onnx|protobuf|hdf5", dynamic), f"{component} needs libonnx, libprotobuf or libhdf5")
            if component == "infer":
                others = set(re.findall(r"NEEDED.*\[(.*)\]", dynamic)) - STANDARD_LIBRARIES
                self.expect(not others, f"infer needs {others}")

    def infer(self):
        tree = self.compile(self.source / "tests/api/consumers/infer")
        self.answers(tree / "frame_cpp", tree / "frame_c")

    def pkg_config(self):
        """With cc and a shell alone; and what estimate() asks of the system."""
        env = {"PKG_CONFIG_PATH": str(self.lib() / "pkgconfig"), "LD_LIBRARY_PATH": str(self.lib())}
        flags = self.run("pkg-config", "--cflags", "--libs", "tactel", env=env).split()
        consumer = self.source / "tests/api/consumers/infer/frame.c"
        self.run(self.cc, consumer, "-o", self.work / "frame_c", *flags)
        for name in NETWORKS:
            self.run(self.work / "frame_c", self.network(name), "none.onnx", env=env)
        self.run(self.cc, "-O1", self.source / "tests/api/steady.c", "-o", self.work / "steady", *flags, "-ldl")
        said = self.run(self.work / "steady", self.network("seed"), env=env)
        self.expect(said == "0 allocations, 0 locks\n", f"estimate: {said}")
        self.expect("-ltactel_simulate" in self.run("pkg-config", "--libs", "tactel-simulate", env=env), "tactel-simulate.pc")

    def subdirectory(self):
        consumer = self.source / "tests/api/consumers/subdirectory"
        self.configure(consumer, f"-DTACTEL_TREE={self.source}")  # everything, not compiled
        shutil.rmtree(self.work / "tree")
        tree = self.compile(consumer, f"-DTACTEL_TREE={self.source}", "-DTACTEL_SIMULATE=OFF",
                            flags="-O1 -D_GLIBCXX_ASSERTIONS -Wconversion")
        self.answers(tree / "frame_cpp")

    def archive(self, *toolchain):
        """tactel::infer as an archive: the answers of the shared library."""
        self.run("cmake", "-G", "Ninja", "-S", self.source, "-B", self.work / "own", "-DTACTEL_SIMULATE=OFF", "-DBUILD_SHARED_LIBS=OFF",
                 f"-DCMAKE_INSTALL_PREFIX={self.work / 'prefix'}", *toolchain)
        self.run("cmake", "--build", self.work / "own", "--parallel", "2")
        self.run("cmake", "--install", self.work / "own")
        self.expect(not list((self.work / "prefix").rglob("*.so*")), "a shared library is installed")
        found = next((self.work / "prefix").rglob("libtactel_infer.a")).parent / "cmake"
        self.run("cmake", "-G", "Ninja", "-S", self.source / "tests/api/consumers/infer", "-B", self.work / "tree", f"-Dtactel_DIR={found / 'tactel'}", *toolchain)
        self.run("cmake", "--build", self.work / "tree")
        return self.work / "tree"

    def static(self):
        shared = self.compile(self.source / "tests/api/consumers/infer").rename(self.work / "shared")
        own = self.archive()
        env = {"PKG_CONFIG_PATH": str(next((self.work / "prefix").rglob("pkgconfig")))}
        flags = self.run("pkg-config", "--static", "--cflags", "--libs", "tactel", env=env).split()
        self.run(self.cc, self.source / "tests/api/consumers/infer/frame.c", "-o", self.work / "by_pkg_config", *flags)
        self.answers(own / "frame_cpp", own / "frame_c", shared / "frame_c", self.work / "by_pkg_config")
        self.expect("tactel" not in self.run("readelf", "-d", own / "frame_cpp"), "the program still loads a library of tactel")

    def aarch64(self):
        """The same for another processor, whose programs QEMU runs: same answers, digit by digit."""
        for program in ("aarch64-linux-gnu-g++", "qemu-aarch64-static"):
            if not shutil.which(program):
                print(f"no {program}: apt-get install g++-aarch64-linux-gnu qemu-user-static")
                sys.exit(77)
        here = self.compile(self.source / "tests/api/consumers/infer").rename(self.work / "here")
        there = self.archive(f"-DCMAKE_TOOLCHAIN_FILE={self.source / 'cmake/aarch64.cmake'}")
        self.answers(here / "frame_cpp", *(["qemu-aarch64-static", there / name] for name in ("frame_cpp", "frame_c")))

    def simulate(self):
        tree = self.compile(self.source / "tests/api/consumers/simulate")
        env = {"ASAN_OPTIONS": "detect_odr_violation=2", "LSAN_OPTIONS": f"suppressions={self.source / 'tests/lsan.supp'}"}
        said = self.run(tree / "scenes", self.source / "examples/until_sliding.toml", self.source / "examples/random_sweep.toml",
                        env=env, cwd=self.work)
        self.expect("S = 1.0000" in said, f"scenes said {said}")

    def snippets(self):
        """Compiles and runs what docs/cpp.md shows: the blocks whose first line names a file."""
        text = (self.source / "docs/cpp.md").read_text()
        for block in re.findall(r"^```(?:cmake|cpp|c)\n(.*?)^```", text, re.M | re.S):
            name = re.match(r"(?:#|//|/\*) (\S+)", block)
            if name is None:
                continue
            path = self.work / name[1]
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block)
        tree = self.compile(self.work, flags="-O1 -Wall -Wextra -Werror")
        said = [self.run(tree / program, self.network("seed")) for program in ("control", "control_c")]
        self.expect(said[0] == said[1] and said[0].startswith("S = 0."), f"control: {said}")
        tree = tree.rename(self.work / "tree_infer")
        tree = self.compile(self.work / "simulate", flags="-O1 -Wall -Wextra -Werror")
        said = self.run(tree / "skin", self.source / "examples/random_sweep.toml", cwd=self.work)
        self.expect("mean error 0." in said and "18 x 9 values" in said, f"skin: {said}")
        said = self.run(tree / "pad", cwd=self.work)
        self.expect(said.count(" N mm: S = 0.") == 8, f"pad: {said}")
        self.expect((self.work / "slip.onnx").exists(), "no network was written")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("step")
    for name in ("build", "source", "prefix"):
        parser.add_argument(f"--{name}", type=pathlib.Path, required=True)
    parser.add_argument("--cc", default="cc")
    parser.add_argument("--cxx", default="c++")
    options = parser.parse_args()
    check = Check(options)
    getattr(check, options.step)()
    print("\n".join(check.findings))
    if not check.findings and options.step != "install":
        shutil.rmtree(check.work, ignore_errors=True)
    sys.exit(1 if check.findings else 0)


if __name__ == "__main__":
    main()
