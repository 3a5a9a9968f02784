# SPDX-License-Identifier: Apache-2.0
"""The bridges of examples/ to ROS 2 and Rerun, with stand-ins for what they import."""
import importlib.util
import io
import json
import os
import pathlib
import tempfile
import types
import unittest
from types import SimpleNamespace as Message
from unittest import mock

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"
PROFILE = "[format]\nkind = \"csv\"\nchannels = 6\n[pad]\ntactels = [2, 1]\npitch = 4\n[channels]\nnormal = [2, 5]\nshear_x = [0, 3]\nshear_y = [1, 4]\n" \
          "[calibration]\ngain = [1e-3, 1e-3, -1e-3, 1e-3, 1e-3, -1e-3]\noffset = 40000\nnoise = 1e-4\n"


def load(path, **modules):
    """The module of a file, and what stands for its imports."""
    with mock.patch.dict("sys.modules", modules):
        spec = importlib.util.spec_from_file_location(path.stem, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    return module


def signed(count):
    return count - 0x10000 if count > 0x7fff else count


class Node:
    """What a node of rclpy does for this example: topics by their name."""

    def __init__(self):
        self.published, self.listens = {}, {}

    def create_publisher(self, _, topic, __):
        self.published[topic] = []
        return Message(publish=lambda message: self.published[topic].append(message.data))

    def create_subscription(self, _, topic, take, __):
        self.listens[topic] = take

    def create_timer(self, seconds, call):
        self.timer = seconds, call


class Ros(unittest.TestCase):
    def test_frames_become_alarms(self):
        node = Node()
        rclpy = types.SimpleNamespace(init=lambda: None, create_node=lambda name: node, spin=None, shutdown=lambda: self.fail("monitor has ended"))
        std, xela = Message(Bool=Message, Float32=Message), Message(SensStream=None)
        module = load(EXAMPLES / "ros2/slip_node.py", rclpy=rclpy, std_msgs=Message(msg=std), **{"std_msgs.msg": std},
                      xela_server_ros2=Message(msg=xela), **{"xela_server_ros2.msg": xela})

        def frame(shear):
            pads = []
            for position in (2, 1):  # the second one comes first
                taxels = [Message(x=signed(40000 + (shear if position == 2 else 0)), y=signed(40000), z=signed(40000 + z)) for z in (300, 100)]
                pads.append(Message(sensor_pos=position, taxels=taxels))
            return Message(sensors=pads)
        self.assertEqual(module.line_of(frame(7)), "40000,40000,40300,40000,40000,40100,40007,40000,40300,40007,40000,40100\n")

        def spin(given):
            for number in range(120):
                given.listens["xServTopic"](frame(0 if number < 100 else 20))  # of 400 counts: sqrt(2) 0.05
        rclpy.spin = spin
        with tempfile.TemporaryDirectory() as folder:
            profile = pathlib.Path(folder) / "pad.toml"
            profile.write_text(PROFILE)
            words = ["slip_node.py", "--profile", str(profile), "--profile", str(profile), "--signal", "moved", "--alarm", "0.06", "--late", "100"]
            with mock.patch("sys.argv", words), mock.patch.dict(os.environ):
                self.assertEqual(module.main(), 0)
        slip, alarm = node.published["slip"], node.published["slip_alarm"]
        self.assertEqual((len(slip), alarm), (120, [False] * 100 + [True] * 20))
        cannot_tell = node.published["slip_cannot_tell"]
        self.assertEqual((cannot_tell[0], cannot_tell[50:]), (True, [False] * 70), "until it rests")
        seconds, listen = node.timer
        listen()
        self.assertEqual((seconds, len(cannot_tell)), (0.5, 120), "the last line is recent")
        with mock.patch.object(module.time, "monotonic", lambda now=module.time.monotonic: now() + 0.6):
            listen()
        self.assertEqual(cannot_tell[120:], [True])
        self.assertAlmostEqual(slip[-1], 0.05 * 2 ** 0.5, places=4)


class Rerun(unittest.TestCase):
    def test_lines_are_logged(self):
        logged = []
        rerun = Message(init=lambda name, spawn: None, set_time=lambda name, duration: logged.append((name, duration)),
                        log=lambda name, value: logged.append((name, value)), Scalars=lambda value: value, BarChart=list)
        module = load(EXAMPLES / "rerun_bridge.py", rerun=rerun)
        line = {"frame": 0, "arrival": 0.5, "slid": 0.25, "moved": None, "alarm": True, "stresses": [[-0.1, -0.2], [0.01, 0]]}
        with mock.patch("sys.stdin", io.StringIO(json.dumps(line) + "\n")):
            module.main()
        self.assertEqual(logged, [("sensor", 0.5), ("slid", 0.25), ("alarm", 1.0), ("stress/normal", [-0.1, -0.2]), ("stress/shear_x", [0.01, 0])])


if __name__ == "__main__":
    unittest.main()
