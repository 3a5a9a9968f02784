# SPDX-License-Identifier: Apache-2.0
"""Whether a wheel has the terms of every library that it packs: check_licenses.py BUILD|WHEEL. Ends with 1 and a line for each that is
missing, and for each library that a wheel neither packs nor finds on every Linux.

The libraries are those that the program and the Python module need, but for the standard ones and MPI, which wheels lack. Terms are those
of a Debian package; those of another package of the same source are the same."""
import pathlib
import re
import subprocess
import sys
import tempfile
import zipfile

EVERYWHERE = re.compile(r"(libc|libm|libdl|librt|libpthread|libgcc_s|libstdc\+\+|ld-linux-x86-64|ld-linux-aarch64)[.]so[.]\d")
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


def listed():
    """The packages whose terms a wheel holds."""
    text = (ROOT / "host/python/CMakeLists.txt").read_text()
    return re.search(r"foreach\(package ([^)]*)\)", text)[1].split()


def of_build(build):
    sources = {source_of(package) for package in listed()}
    all_needed = {}
    for file in (build / "tactel", *build.glob("libtactel_*.so"), *build.glob("python/tactel/_tactel*.so")):
        needed(file, all_needed)
    yield from {f"{path}: no terms of {source} in the wheel; add its package to host/python/CMakeLists.txt"
                for path, source in all_needed.items() if source not in sources | OUTSIDE}
    if not all_needed:
        yield f"{build}: nothing is built"


def of_wheel(wheel):
    """auditwheel writes the first digits of a checksum into the name of what it packs: libudev-bd5a2ef5.so.1.7.5."""
    with tempfile.TemporaryDirectory() as folder:
        zipfile.ZipFile(wheel).extractall(folder)
        files = [path for path in pathlib.Path(folder).rglob("*") if path.is_file()]
        terms = {path.name for path in files if path.parent.name == "licenses" and path.parent.parent.name == "tactel" and path.stat().st_size}
        yield from (f"{name}: no terms in tactel/licenses" for name in {"pybind11", *listed()} - terms)
        sources = {source_of(package) for package in terms - {"pybind11"}}
        binaries = [path for path in files if path.read_bytes()[:4] == b"\x7fELF"]
        inside = {path.name for path in binaries}
        for path in binaries:
            if path.parent.name == "tactel.libs":
                owner = said("dpkg", "-S", "*/" + re.sub(r"-[0-9a-f]{8}(?=[.])", "", path.name)).split(":")[0]
                if source_of(owner) not in sources:
                    yield f"{path.name}: no terms of {owner} in tactel/licenses; add it to host/python/CMakeLists.txt"
            for name in re.findall(r"NEEDED.*\[(.*)\]", said("readelf", "-d", path)):
                if name not in inside and not EVERYWHERE.match(name):
                    yield f"{path.name}: needs {name}, which is not in the wheel"


def main(place):
    missing = sorted((of_wheel if place.suffix == ".whl" else of_build)(place))
    for line in missing:
        print(line)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
