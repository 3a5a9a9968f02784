# SPDX-License-Identifier: Apache-2.0
"""Wrong calls of the package as InputError, which names the argument. Its names and types are those of __init__.pyi. Wrong calls of its
commands as exit codes."""

import ast
import difflib
import functools
import itertools
import os
import pathlib
import re
import reprlib
import sys

from . import _tactel  # type: ignore[attr-defined]


def input_error(place, problem, fix):
    """Returns an InputError as the library raises it."""
    error = _tactel.InputError(f"{place}: {problem}; {fix}")
    error.place, error.problem, error.fix = place, problem, fix
    return error


def exit_code(command, run, *given):
    """Returns the exit code of `python -m tactel.COMMAND`, which run(*given) returns; an error becomes a line, and the code of the program."""
    try:
        return run(*given)
    except (KeyboardInterrupt, _tactel.Cancelled):
        return 130
    except (_tactel.InputError, _tactel.HardwareError, OSError) as error:
        print(f"tactel.{command}: {error}", file=sys.stderr)
        return 3 if isinstance(error, _tactel.HardwareError) else 2


def write_text(path, text):
    """Writes a file as a whole: whatever ends the process, the file is the old one or the new one."""
    new = f"{path}.{os.getpid()}.new"
    try:
        with open(new, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(new, path)
    finally:
        pathlib.Path(new).unlink(missing_ok=True)


def unknown(place, name, names, kind="argument"):
    """Returns the InputError of a name that is not among these."""
    near = difflib.get_close_matches(name, names, 1)
    return input_error(place, f"no {kind} {name}", f"did you mean {near[0]}?" if near else f"it has {', '.join(names) or 'none'}")


@functools.cache
def _signatures():
    """Arguments of each function and method, one for each of its overloads: {"Sensor": [ast.arguments]}."""
    stub = pathlib.Path(__file__).with_name("__init__.pyi")
    tree = ast.parse(stub.read_text(encoding="utf-8") if stub.exists() else "")
    aliases = {node.targets[0].id: ast.unparse(node.value) for node in tree.body if isinstance(node, ast.Assign)}
    aliases |= {node.name: ast.unparse(node.bases[0]) for node in tree.body
                if isinstance(node, ast.ClassDef) and node.name.startswith("_") and node.bases}
    found = {}

    def add(nodes, prefix, methods):
        for node in nodes:
            if isinstance(node, ast.FunctionDef):
                static = not methods or any(isinstance(of, ast.Name) and of.id == "staticmethod" for of in node.decorator_list)
                node.args.args = node.args.args[0 if static else 1:]
                for one in node.args.args + node.args.kwonlyargs:
                    known = re.sub(r"\w+", lambda word: aliases.get(word[0], word[0]), ast.unparse(one.annotation))
                    one.annotation = ast.parse(known, mode="eval").body
                node.args.made = ast.unparse(node.returns)
                found.setdefault(re.sub(r"\.__(init|new)__$", "", prefix + node.name), []).append(node.args)
            elif isinstance(node, ast.ClassDef):
                add(node.body, node.name + ".", True)

    add(tree.body, "", False)
    return found


def _fits(value, wanted):
    """Whether a value may be of a type, as far as its first elements tell."""
    if isinstance(wanted, ast.BinOp):
        return _fits(value, wanted.left) or _fits(value, wanted.right)
    if isinstance(wanted, ast.Constant):
        return value is wanted.value
    kind, _, _ = ast.unparse(wanted).partition("[")
    if kind == "float":
        return hasattr(type(value), "__float__") and not getattr(value, "shape", ())
    if kind == "int":
        return hasattr(type(value), "__index__") and not getattr(value, "shape", ())
    if kind == "bool":
        return type(value).__name__ in ("bool", "bool_")
    if kind == "str":
        return isinstance(value, str)
    if kind == "os.PathLike":
        return hasattr(type(value), "__fspath__")
    if kind == "Literal":
        of = {type(ast.literal_eval(one)).__name__ for one in getattr(wanted.slice, "elts", [wanted.slice])}
        return any(_fits(value, ast.Name(one)) for one in of)
    if kind == "Callable":
        return callable(value)
    if kind in ("Sequence", "Iterable", "list", "tuple"):
        of = wanted.slice.elts[0] if isinstance(wanted.slice, ast.Tuple) else wanted.slice
        try:
            return not isinstance(value, str) and all(_fits(one, of) for one in itertools.islice(value, 100))
        except TypeError:  # no list
            return False
    known = getattr(_tactel, kind, None)
    return isinstance(value, known) if isinstance(known, type) else True


def _fault(name, arguments, args, kwargs, names):
    """Returns how near the call is to these arguments, the place of its fault, the problem and the fix; None where it fits."""
    by_place = [one.arg for one in arguments.args]
    annotations = {one.arg: one.annotation for one in arguments.args + arguments.kwonlyargs}
    for word in kwargs:
        if word not in annotations and not arguments.kwarg:
            error = unknown(name, word, names)
            return 0, name, error.problem, error.fix
    if len(args) > len(by_place):
        problem = f"{len(args)} argument{'s' if args[1:] else ''} without a name"
        return 1, name, problem, f"at most {len(by_place)}: {', '.join(by_place)}" if by_place else "give none"
    given = dict(zip(by_place, args))
    for word in kwargs.keys() & given.keys():
        return 1, name, f"{word} twice", "leave one out"
    given |= kwargs
    needed = by_place[:len(by_place) - len(arguments.defaults)]
    needed += [one.arg for one, usual in zip(arguments.kwonlyargs, arguments.kw_defaults) if usual is None]
    if missing := [word for word in needed if word not in given]:
        return 1, name, f"no {', '.join(missing)}", "give " + ("them" if missing[1:] else "it")
    for place, (word, value) in enumerate(given.items(), 2):
        if annotations.get(word) is not None and not _fits(value, annotations[word]):
            return place, f"{name}: {word}", f"{reprlib.repr(value)}, of type {type(value).__name__}", ast.unparse(annotations[word])
    return None


def _wrong(name, args, kwargs, error):
    """Returns the InputError of a call that raised a TypeError, or None where the call was right."""
    if "No constructor defined" in str(error):
        makers = [maker for maker, overloads in _signatures().items() if "._" not in maker
                  and any(re.search(rf"\b{name}\b", one.made) for one in overloads)]
        return input_error(name, "no constructor", f"it is made by {', '.join(makers)}") if makers else None
    overloads = _signatures().get(name) or []
    names = list(dict.fromkeys(one.arg for each in overloads for one in each.args + each.kwonlyargs))
    faults = [_fault(name, arguments, args, kwargs, names) for arguments in overloads]
    if faults and all(faults):
        nearest, place, problem, fix = max(faults, key=lambda fault: fault[0])
        if nearest > 1:  # a type; overloads may have others
            fix = "must be " + " | ".join(dict.fromkeys(types for near, _, _, types in faults if near == nearest))
        return input_error(place, problem, fix)
    if overloads and re.search("incompatible (function|constructor) arguments", str(error)):  # a type that is more than it shows
        given = ", ".join([reprlib.repr(value) for value in args] + [f"{word}={reprlib.repr(value)}" for word, value in kwargs.items()])
        return input_error(name, f"({given})", f"must be ({ast.unparse(overloads[faults.index(None)])})")
    return None


def _checked(name, function, is_method):
    """Returns the function, whose wrong arguments raise InputError."""

    @functools.wraps(function)
    def call(*args, **kwargs):
        try:
            return function(*args, **kwargs)
        except TypeError as error:
            wrong = None if isinstance(error, _tactel.InputError) else _wrong(label, args[is_method:], kwargs, error)
            if wrong is None:
                raise
            raise wrong from None

    label = name.removesuffix(".__init__")
    call.__module__, call.__qualname__ = "tactel", name
    return call


def check(scope, names):
    """Checks the calls of these functions, and of all methods of these classes."""
    for name in names:
        public = scope[name]
        if not isinstance(public, type):
            if callable(public):
                scope[name] = _checked(name, public, False)
        elif not issubclass(public, BaseException):
            members = {member: value for base in reversed(public.__mro__) if base.__module__.startswith("tactel")
                       for member, value in vars(base).items()}
            for member, value in members.items():
                static = isinstance(value, staticmethod)
                if (callable(value) or static) and (member in ("__init__", "__call__") or not member.startswith("_")):
                    own = _checked(f"{name}.{member}", getattr(public, member), not static)
                    setattr(public, member, staticmethod(own) if static else own)
