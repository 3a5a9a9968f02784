# SPDX-License-Identifier: Apache-2.0
"""Checks that includes between the rooms of host/ run downwards only, that third parties stay in their rooms, and that no two
sources of a room give a function of their own the same name: compiled as one (TACTEL_UNITY), either might call the other's.

Usage: check_includes.py HOST_FOLDER ROOM=LEVEL...
Prints every finding as FILE:LINE: problem; ends with 1 where there is one."""
import pathlib
import re
import sys

# Headers of a third party, by how they begin, and the rooms that may include them.
THIRD_PARTIES = {
    "CL/": {"device"},
    "CLI/": {"commands"},
    "toml++/": {"scenes"},
    "hdf5": {"sets"},
    "mpi.h": {"support"},
    "onnx/": set(),  # tests alone
    "google/": set(),
    "libusb": set(),
    "Eigen/": None,  # everywhere
}


def problems(host, levels):
    for path in sorted([*host.rglob("*.h"), *host.rglob("*.cpp")]):
        parts = path.relative_to(host).parts
        if len(parts) == 1:
            yield f"{path}:1: stands at the root of host/; put it into a room"
            continue
        room = parts[0]
        if room not in levels:
            yield f"{path}:1: {room}/ is no room; add it to host/CMakeLists.txt"
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            include = re.match(r'\s*#\s*include\s*["<]([^">]+)[">]', line)
            if include:
                problem = problem_of(include[1], room, levels)
                if problem:
                    yield f"{path}:{number}: {problem}"


def own_functions(path):
    """Names and lines of the functions in a source's unnamed namespaces."""
    unnamed = False
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if line.startswith("namespace {"):
            unnamed = True
        elif line == "}  // namespace":
            unnamed = False
        elif unnamed and (definition := re.match(r"[A-Za-z_\[][^=({]*[ *&](\w+)\(", line)):
            yield definition[1], number


def same_names(host):
    for room in sorted(path for path in host.iterdir() if path.is_dir()):
        first = {}
        for path in sorted(room.rglob("*.cpp")):
            for name, number in own_functions(path):
                other = first.setdefault(name, path)
                if other != path:
                    yield f"{path}:{number}: {name}() stands in {other}, too; rename one, or share it"


def problem_of(header, room, levels):
    if header.startswith("host/"):
        other = header.split("/")[1]
        if other != room and levels.get(other, 0) >= levels[room]:
            return f"{room} (level {levels[room]}) includes {header} (level {levels.get(other, 'unknown')}); only lower levels may be included"
    if header.startswith(("tests/", "bench/")):
        return f"includes {header}; the product does not know its tests"
    for start, rooms in THIRD_PARTIES.items():
        if header.startswith(start) and rooms is not None and room not in rooms:
            return f"{room} includes {header}; only {', '.join(sorted(rooms)) or 'hw'} may"
    return None


def main():
    host = pathlib.Path(sys.argv[1])
    levels = {name: int(level) for name, level in (word.split("=") for word in sys.argv[2:])}
    found = [*problems(host, levels), *same_names(host)]
    print("\n".join(found))
    if not levels or not any(host.rglob("*.h")):
        found.append("nothing to check")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
