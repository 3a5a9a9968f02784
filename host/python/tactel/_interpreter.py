# SPDX-License-Identifier: Apache-2.0
"""Refuses a subinterpreter, where the module, as others of pybind11, would wait for ever for the lock of Python."""

import importlib

for _name in ("_interpreters", "_xxsubinterpreters"):  # from Python 3.13 on, and before
    try:
        _all = importlib.import_module(_name)
    except ImportError:
        continue
    if _all.get_current() != _all.get_main():
        raise ImportError("tactel: works in the main interpreter of a process alone; import it there, or take processes (multiprocessing)")
    break
