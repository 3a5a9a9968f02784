# SPDX-License-Identifier: Apache-2.0
"""Whether a wheel has the terms of every library that it packs: check_licenses.py BUILD. Ends with 1 and a line for each that is missing.

The libraries are those that the program and the Python module need, but for the standard ones and MPI, which wheels lack. Terms are those
of a Debian package; those of another package of the same source are the same."""
import pathlib
import re
import subprocess
import sys

OUTSIDE = {"glibc", "gcc-12", "openmpi"}  # sources of packages that are no part of a wheel
ROOT = pathlib.Path(__file__).parents[2]


def said(*words):
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


def source_of(package):
    return said("dpkg-query", "-W", "-f", "${source:Package}\n", package).split("\n")[0]


def needed(file, seen):
    """Paths of the libraries that a file needs, and of those that these need, but for those of sources that are outside."""
    paths = dict(re.findall(r"(\S+) => (/\S+)", said("ldd", file)))
    for name in re.findall(r"NEEDED.*\[(.*)\]", said("readelf", "-d", file)):
        path = paths.get(name)
        if path is None or path in seen or "tactel" in name:
            continue
        seen[path] = next(source_of(package) for place in (path, path.removeprefix("/usr"), f"/usr{path}")
                          for package in re.findall(r"^(\S+?):? ", subprocess.run(["dpkg", "-S", place], capture_output=True, text=True).stdout))
        if seen[path] not in OUTSIDE:
            needed(path, seen)
    return seen


def main(build):
    text = (ROOT / "host/python/CMakeLists.txt").read_text()
    packages = re.search(r"foreach\(package ([^)]*)\)", text)[1].split()
    sources = {source_of(package) for package in packages}
    all_needed = {}
    for file in (build / "tactel", *build.glob("libtactel_*.so"), *build.glob("python/tactel/_tactel*.so")):
        needed(file, all_needed)
    missing = sorted({f"{path}: no terms of {source} in the wheel; add its package to host/python/CMakeLists.txt"
                      for path, source in all_needed.items() if source not in sources | OUTSIDE})
    print("\n".join(missing))
    return 1 if missing or not all_needed else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
