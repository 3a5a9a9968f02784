#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Shows lines of `tactel monitor --stresses` in Rerun (pip install rerun-sdk): S or what the alarm judges, the alarm, the stresses.

    tactel monitor ... --stresses | python3 rerun_bridge.py

Tested with a recorder in the place of Rerun."""
import json
import sys

import rerun


def main():
    rerun.init("tactel", spawn=True)
    for line in sys.stdin:
        answer = json.loads(line)
        rerun.set_time("sensor", duration=answer["arrival"])
        for key in ("slip_index", "slip_upper", "slid", "moved", "left", "true_slip_index", "alarm"):
            if answer.get(key) is not None:
                rerun.log(key, rerun.Scalars(float(answer[key])))
        for name, values in zip(("normal", "shear_x", "shear_y"), answer["stresses"]):
            rerun.log(f"stress/{name}", rerun.BarChart(values))


if __name__ == "__main__":
    main()
