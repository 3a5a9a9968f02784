# SPDX-License-Identifier: Apache-2.0
"""What the studies of this folder share: options, the program, rows of tables, the looks of figures."""
import argparse
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
EXACT, BLUE, ORANGE, GREEN = "#222222", "#1f5fa8", "#d9660a", "#2e7d32"
LOOKS = {"font.size": 10, "axes.grid": True, "grid.color": "#dddddd", "axes.axisbelow": True, "legend.frameon": False,
         "svg.fonttype": "none", "svg.hashsalt": "tactel", "font.family": "DejaVu Sans", "lines.markersize": 5,
         "figure.facecolor": "white"}


def options(text):
    """A parser that prints the text of a study, with --build."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"), help="holds the program")
    return parser


class Program:
    """The program in a build folder. A call runs a command and returns what it prints; the study ends where it fails, but for
    sets with contacts that are not solved, which are marked."""

    def __init__(self, build):
        self.path = build.resolve() / "tactel"
        if not self.path.is_file():
            raise SystemExit(f"{self.path}: no such program; build it, or name its folder by --build")

    def __call__(self, *words):
        done = subprocess.run([self.path, *map(str, words)], capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if done.returncode != 0 and (done.returncode != 4 or words[0] != "generate"):
            raise SystemExit(f"tactel {' '.join(map(str, words))}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout


def row(*cells):
    """A row of a table in Markdown."""
    return "| " + " | ".join(map(str, cells)) + " |"


def head(*names):
    """The row of names of a table, and the line below it."""
    return row(*names) + "\n" + "|---" * len(names) + "|"


def panels(*shape, **looks):
    """A figure and its axes, as matplotlib.pyplot.subplots returns them, with the looks of all studies."""
    import matplotlib
    matplotlib.use("svg")
    import matplotlib.pyplot as plt
    plt.rcParams.update(LOOKS)
    return plt.subplots(*shape, layout="constrained", **looks)


def save(figure, path):
    """Writes and closes a figure. The same numbers give the same file."""
    import matplotlib.pyplot as plt
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)
