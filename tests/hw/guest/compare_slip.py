# SPDX-License-Identifier: Apache-2.0
"""S as the guest found it live, against S of its recording on this machine: compare_slip.py TACTEL FOLDER."""
import json
import subprocess
import sys
from pathlib import Path

program, folder = sys.argv[1], Path(sys.argv[2])
live = json.loads((folder / "live.json").read_text())
recall = subprocess.run([program, "monitor", "--quiet", "--source", f"replay:{folder}/usb.tactel", "--network", f"{folder}/network.onnx"],
                        check=True, capture_output=True, text=True)
here = [json.loads(line)["slip_index"] for line in recall.stdout.splitlines()][: len(live)]
assert len(here) == len(live), f"{len(here)} frames here, {len(live)} in the guest"
largest = max(abs(a - b) for a, b in zip(live, here))
same = sum(a == b for a, b in zip(live, here))
print(f"{len(live)} frames: {same} with the same bits on both processors, largest difference in S {largest:.2e}")
# Another processor's code may sum in another order: 128 terms in each of two layers, half a unit in the last place each (6e-8).
sys.exit(largest > 2 * 128 * 6e-8)
