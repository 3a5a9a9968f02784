# SPDX-License-Identifier: Apache-2.0
"""Writes the types of the built package tactel in a folder, its __init__.pyi: stubs.py FOLDER.

Those of the module are pybind11's signatures; those of functions in Python, and the names of types, are those of __init__.py."""

import ast
import inspect
import pathlib
import re
import sys
import textwrap

sys.path[0] = sys.argv[1]
import tactel

FILE = pathlib.Path(tactel.__file__)
SOURCE = ast.parse(FILE.read_text(encoding="utf-8"))
NAMES = next(node.body for node in SOURCE.body if isinstance(node, ast.If))  # what type checkers alone see
SPECIAL = {"__init__", "__len__", "__call__", "__iter__", "__next__", "__enter__", "__exit__", "__array__", "__dlpack__", "__dlpack_device__", "__int__", "__index__", "_repr_html_"}
# Words of pybind11, from 2.12 on: those of all types, of arguments, and of what a function returns.
WORDS = [(r"\b(tactel\._tactel|typing|collections\.abc|numpy\.typing)\.", ""), (r"\b(List|Tuple|Dict)\b", lambda word: word[0].lower()),
         (r"Supports(Int|Float)( \| SupportsIndex)?", lambda word: word[1].lower()), (r"\bobject\b", "Any"), (r"= <[^>]*>", "= ..."),
         (r"numpy\.ndarray\[(?=numpy)|numpy\.ndarray\[(?=bool)", "NDArray["), (r"(NDArray\[)(numpy\.)?bool\]", r"\1numpy.bool_]"),
         (r"\bnumpy\.", "np."), (r"(\*+\w+)(?=,|$)", r"\1: Any")]
TAKEN = [(r"\blist\[", "Sequence["), (r"Annotated\[Sequence\[(\w+)\], \"?FixedSize\(2\)\"?\]", r"tuple[\1, \1] | list[\1]"),
         (r"Annotated\[ArrayLike, [\w.]+\]|NDArray\[[\w.]+\]", "ArrayLike")]
MADE = [(r"Annotated\[(list\[\w+\]), \"?FixedSize\(2\)\"?\]", r"\1")]


class Unions(ast.NodeTransformer):
    """Optional[a] as a | None, Union[a, b] as a | b."""

    def visit_Subscript(self, node):
        self.generic_visit(node)
        kind, types = ast.unparse(node.value), getattr(node.slice, "elts", [node.slice])
        if kind not in ("Optional", "Union"):
            return node
        return ast.parse(" | ".join([ast.unparse(one) for one in types] + ["None"] * (kind == "Optional")), mode="eval").body


def words(text, more):
    for pattern, replacement in WORDS + more:
        text = re.sub(pattern, replacement, text)
    return text


def in_python():
    """The functions of __init__.py by their names: [(arguments, answer, docstring)], one for each overload."""
    found = {}
    for scope, body in [("", SOURCE.body)] + [(f"{node.name}.", node.body) for node in SOURCE.body if isinstance(node, ast.ClassDef)]:
        for node in body:
            if isinstance(node, ast.FunctionDef):
                found.setdefault(scope + node.name, []).append(node)
    return {name: [(ast.unparse(node.args), node.returns and ast.unparse(node.returns), ast.get_docstring(nodes[-1]) or "")
                   for node in nodes[:-1] or nodes] for name, nodes in found.items()}


PYTHON = in_python()


def definitions(name, value, is_method=False):
    """The definitions of a function, one for each overload."""
    function = inspect.unwrap(getattr(value, "__func__", value))
    found = [(name, *one) for one in PYTHON.get(getattr(function, "__qualname__", ""), [])]
    if not found:
        parts = re.split(r"^(?:\d+\. )?(\w+)\((.*)\) -> (.*)$", function.__doc__ or "", flags=re.MULTILINE)
        for own_name, arguments, made, text in zip(*(parts[k::4] for k in (1, 2, 3, 4))):
            assert own_name in (name, "__new__"), f"{name}: the signature is that of {own_name}"
            if is_method and own_name != "__new__":
                arguments = re.sub(r"^\w+(: [^,]*)?", "self", arguments)
            found.append((own_name or name, words(arguments, TAKEN), words(made, MADE), text.strip()))
    for own_name, arguments, made, text in found:
        yield from ["@overload"] * (len(found) > 1) + ["@staticmethod"] * isinstance(value, staticmethod)
        yield f"def {own_name}({arguments}) -> {made}: {repr(text) if text else '...'}"


def members(which):
    """The members of a class, and of its bases in the module."""
    found = {name: value for base in reversed(which.__mro__) if base.__module__.startswith("tactel") for name, value in vars(base).items()}
    yield repr(which.__doc__ or "")
    for name, kind in getattr(which, "__annotations__", {}).items():
        yield f"{name}: {kind}"
    for name, value in found.items():
        if name.startswith("_") and name not in SPECIAL:
            continue
        if isinstance(value, property):
            made = words(re.search(r"\) -> (.*)", value.fget.__doc__)[1], MADE)
            yield f"@property\ndef {name}(self) -> {made}: {repr(value.__doc__) if value.__doc__ else '...'}"
        elif isinstance(value, which):
            yield f"{name}: {which.__name__}"
        elif isinstance(value, int):
            yield f"{name}: int"
        else:
            yield from definitions(name, value, not isinstance(value, staticmethod))


def described(name):
    value = getattr(tactel, name)
    if isinstance(value, type):
        bases = [base.__name__ for base in value.__bases__ if base.__name__ in {*tactel.__all__, *dir(__builtins__)} - {name, "object"}]
        return f"class {name}({', '.join(bases)}):\n" + textwrap.indent("\n".join(members(value)), "    ")
    return "\n".join(definitions(name, value)) if callable(value) else f"{name}: {type(value).__name__}"


for union, owner in ("Shape", tactel.Indenter), ("PadShape", tactel.PadIndenter):
    shapes = words(re.search(r"\) -> (.*)", owner.shape.fget.__doc__)[1], MADE)
    NAMES.append(Unions().visit(ast.parse(f"{union} = {shapes}")).body[0])
text = ast.unparse(Unions().visit(ast.parse("\n".join(map(described, ["__version__", *tactel.__all__])))))
for node in NAMES:
    if isinstance(node, ast.Assign):
        text = text.replace(ast.unparse(node.value), node.targets[0].id)
names = "\n".join(ast.unparse(node) for node in NAMES)
FILE.with_suffix(".pyi").write_text(f'"""Types of the package tactel, written by its build."""\n{names}\n\n{text}\n', encoding="utf-8")
