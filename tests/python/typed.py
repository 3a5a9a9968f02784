# SPDX-License-Identifier: Apache-2.0
"""A program with types, which mypy --strict checks and nothing runs: what users call, and what it gives."""

from pathlib import Path
from typing import assert_type

import numpy as np
import tactel
from numpy.typing import NDArray

sensor = tactel.Sensor(length=20, thickness=1.5, tactels=21)
scene = tactel.Scene(sensor, tactel.Parabola(radius=10), friction=0.5, load=tactel.Press(0.15).drag(0.05, steps=8))
assert_type(scene.with_(friction=0.3).sensor, tactel.Sensor)



def harder(any_scene: tactel.Scene) -> tactel.Scene:
    return any_scene.with_(friction=0.9)


path = tactel.solve(scene, accuracy=0.01)
assert_type(path.slip_index, NDArray[np.float64])
assert_type(path.frames, NDArray[np.float32])
assert_type(path.tactels.normal, NDArray[np.float64])

many = tactel.solve_many([scene.with_(friction=mu) for mu in np.linspace(0.1, 1, 10)], progress=True)
assert_type(many, tactel.Paths)
assert_type(many.converged, NDArray[np.uint8])
tactel.solve_many([scene], keep="tactels", progress=lambda done, total: print(done, total))

box = tactel.PadIndenter(tactel.Box((2, 1.5), edge=0.5), position=(1, 0), yaw=30)
on_pad = tactel.Scene(tactel.Pad(tactels=(4, 6)), box, load=tactel.Press(0.2).drag((0.05, 0), steps=3, twist=1))
assert_type(on_pad.load, tactel.PadLoad)
assert_type(tactel.solve(on_pad.with_(friction=0.3)).tactels.shear_x, NDArray[np.float64])
assert_type(tactel.solve_many([on_pad]), tactel.PadPaths)
tactel.Scene(tactel.Pad(), tactel.Parabola(10))  # type: ignore[call-overload]  # a shape of a line
print(tactel.solve(tactel.read_scene(Path("examples/pad.toml"))).P)

sweep = tactel.Sweep("examples/random_sweep.toml")
for frames, slip_index in sweep.batches(8192, seed=7):
    assert_type(frames, NDArray[np.float32])
    break
for part in sweep.batches(sets=True):
    assert_type(part, tactel.Set)
    break

networks = tactel.train(sweep.generate(1000), layers=(42, 42, 21, 1), noise=[0.0, 0.1], scaling="frame")
assert_type(networks, list[tactel.Network])
assert_type(networks[0].learning_errors.mean, float)
networks[0].to_onnx("slip.onnx")

with tactel.open_sensor("simulate:examples/parabola.toml") as stream:
    for frame in stream:
        print(networks[0](frame), frame.device_time, np.asarray(frame))

hand = tactel.LiveEstimator([networks[0], networks[0]], tactel.devices()[0].name)
assert_type(hand.next(np.zeros(hand.inputs))[0], tactel.Answer)
assert_type(tactel.Alarm(networks[0], device="cpu").next(np.zeros(42)).on, bool)

try:
    tactel.solve(scene, precision="fp16")  # type: ignore[call-overload]  # a mistake that the types find
except tactel.InputError as error:
    print(error.place, error.problem, error.fix)
