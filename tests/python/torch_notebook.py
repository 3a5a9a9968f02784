#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the tutorial that needs PyTorch, which takes 5 GB: torch_notebook.py FOLDER, where it is installed. 77: it cannot be had."""
import os
import subprocess
import sys

if subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--target", sys.argv[1], "torch"]).returncode:
    sys.exit(77)
os.environ["PYTHONPATH"] += os.pathsep + sys.argv[1]
sys.exit(subprocess.run([sys.executable, "tests/python/run_notebook.py", "examples/tutorials/own_torch_network.ipynb"]).returncode)
