# SPDX-License-Identifier: Apache-2.0
"""A hook of mkdocs: appends to reference.md the help of each command, and the names of the Python package, with signatures from its
stub and texts from itself. Names in the list of that page become links to them; a name that the package lacks is an error."""
import ast
import html
import os
import pathlib
import re
import subprocess
import sys

import tactel

STUB = pathlib.Path(tactel.__file__).with_name("__init__.pyi")
PROGRAM = pathlib.Path(__file__).parents[1] / "build/tactel"
MODULES = ("calibrate", "floor", "import_network", "mcap")


def text_of(thing):
    """Its docstring as a paragraph, without the signatures that pybind11 puts between the lines."""
    text = re.sub(r"^(\d+\. )?\w+\(.*\) -> .*$|^\w+\(\*args, \*\*kwargs\)$|^Overloaded function\.$|^Initialize self\..*$", "", thing.__doc__ or "", flags=re.M)
    parts = re.split(r"(`[^`]*`)", " ".join(text.split()))
    return "".join(part if part.startswith("`") else re.sub(r"([\\*_|])", r"\\\1", html.escape(part)) for part in parts)


def signature(name, function, width):
    arguments = re.split(r", (?=\*?\w+:|\*,)", re.sub(r"^(self|cls)(: \w+)?(, |$)", "", ast.unparse(function.args)))
    returns = ast.unparse(function.returns) if function.returns and function.name not in ("__init__", "__new__") else "None"
    end = ")" if returns == "None" else f") -> {returns}"
    line = f"{name}({', '.join(arguments)}{end}"
    broken = f"{name}(\n    " + ",\n    ".join(arguments) + f",\n{end}"
    return (line if len(line) <= width else broken).replace("_LineScene", "Scene").replace("_PadScene", "Scene")


def signatures(name, functions, width=90):
    """Of every overload, but for those that merge the others."""
    if len(functions) > 1:
        functions = [one for one in functions if ast.unparse(one.returns) != "Any"]
    return [signature(name, one, width) for one in functions]


def block(lines):
    return "```python\n" + "\n".join(lines) + "\n```\n"


def described(name, nodes):
    """The section of a class or function, by its definitions in the stub."""
    thing = getattr(tactel, name)
    yield f"### {name}\n"
    if isinstance(nodes[0], ast.FunctionDef):
        yield block(signatures(name, nodes))
        yield text_of(thing) + "\n"
        return
    by_name = {}
    for node in nodes[0].body:
        if isinstance(node, ast.FunctionDef):
            by_name.setdefault(node.name, []).append(node)
    makers = by_name.get("__init__") or by_name.get("__new__")
    if makers:
        yield block(signatures(name, makers))
    yield " ".join(filter(None, [text_of(thing), text_of(thing.__init__) if "__init__" in vars(thing) else ""])) + "\n"
    for member, functions in by_name.items():
        if member.startswith("_") and member != "__call__":
            continue
        if any(ast.unparse(one) == "property" for one in functions[0].decorator_list):
            heads = [f"{member}: {ast.unparse(functions[0].returns)}"]
        else:
            heads = signatures(member, functions, width=10_000)
        text = text_of(getattr(thing, member))
        yield "- " + ", ".join(f"`{head}`" for head in heads) + (f"<br>{text}" if text else "")
    yield ""


def helps(title, command):
    """The section of a command, or one for each of its own."""
    run = subprocess.run([*command, "--help"], check=True, capture_output=True, text=True, env={**os.environ, "COLUMNS": "80"})
    own = re.findall(r"^ {2,4}([a-z-]+)  ", run.stdout, re.M) if re.search(r"^usage: .* COMMAND|\{\w+,.*\.\.\.", run.stdout, re.I | re.M) else []
    for word in own:
        yield from helps(f"{title} {word}", [*command, word])
    if not own:
        yield f"### {title}\n\n```text\n{run.stdout.strip()}\n```\n"


def commands():
    yield from helps("tactel", [PROGRAM])
    for module in MODULES:
        yield from helps(f"tactel.{module}", [sys.executable, "-m", f"tactel.{module}"])


def on_page_markdown(markdown, page, **_):
    if page.file.src_path != "reference.md":
        return markdown
    nodes, types = {}, []
    for node in ast.parse(STUB.read_text()).body:
        if isinstance(node, ast.Assign) and not node.targets[0].id.startswith("_"):
            types.append(ast.unparse(node))
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and node.name in tactel.__all__:
            nodes.setdefault(node.name, []).append(node)
    linked = re.sub(r"`(\w+)`", lambda found: f"[`{found[1]}`](#{nodes[found[1]][0].name.lower()})", markdown)
    return linked + "\n" + "\n".join(commands()) + "\n## Names\n\nSignatures abbreviate types:\n\n" + block(types) + "\n".join(line for name in sorted(nodes, key=str.lower) for line in described(name, nodes[name]))
