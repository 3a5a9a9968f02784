#!python
# SPDX-License-Identifier: Apache-2.0
"""The command tactel of the Python package: the program that lies in the package. Loads neither the package nor NumPy."""

import importlib.util
import os
import runpy
import sys

folder = os.path.dirname(importlib.util.find_spec("tactel").origin)
runpy.run_path(os.path.join(folder, "_driver.py"))
os.execv(os.path.join(folder, "tactel"), sys.argv)
