# SPDX-License-Identifier: Apache-2.0
"""Names the OpenCL driver that `pip install intel-opencl-rt` puts into this environment, where the system has none."""

import glob
import os
import sys

_driver = os.path.join(sys.prefix, "lib", "libintelocl.so")
if os.path.exists(_driver) and not glob.glob("/etc/OpenCL/vendors/*.icd"):
    os.environ.setdefault("OCL_ICD_VENDORS", _driver)
