# SPDX-License-Identifier: Apache-2.0
"""tactel.mcap: messages of ROS, serialised here by hand, come as lines of numbers; monitor says of them what it says of the same numbers."""
import contextlib
import io
import json
import os
import pathlib
import struct
import subprocess
import tempfile
import unittest

import tactel.mcap as files
from mcap.writer import Writer
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore
from tactel import InputError

LINE = "=" * 80
ARRAY = f"""std_msgs/MultiArrayLayout layout
float32[] data
{LINE}
MSG: std_msgs/MultiArrayLayout
std_msgs/MultiArrayDimension[] dim
uint32 data_offset
{LINE}
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride
"""
SKIN = f"""std_msgs/Header header
Taxel[] taxels
{LINE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{LINE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{LINE}
MSG: skin_msgs/Taxel
float32 x
float32 y
float32 z
uint8 id
"""
PROFILE = "[format]\nkind = \"csv\"\nchannels = 6\n[pad]\ntactels = [2, 1]\npitch = 4\n[channels]\nnormal = [2, 5]\nshear_x = [0, 3]\nshear_y = [1, 4]\n" \
          "[calibration]\ngain = 0.001\noffset = 0\nnoise = 0.0001\n"
START = 1_795_000_000 * 10**9  # ns
ROWS = [[k % 7 / 4, k % 5 - 2, -400 - k % 3, 1.5, -2.25, -100] for k in range(40)]  # exact in fp32


def array(row):
    """layout: no dimensions, offset 0; then the data."""
    return struct.pack(f"<3I{len(row)}f", 0, 0, len(row), *row)


def of_ros2(body):
    return b"\0\1\0\0" + body  # CDR, little-endian


class Bags(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def mcap(self, *bodies, schema=("std_msgs/msg/Float32MultiArray", ARRAY)):
        path = self.folder / "ros2.mcap"
        with open(path, "wb") as file:
            writer = Writer(file)
            writer.start("ros2")
            channel = writer.register_channel("/tactile", "cdr", writer.register_schema(schema[0], "ros2msg", schema[1].encode()))
            for number, body in enumerate(bodies):
                writer.add_message(channel, START + number * 10**7, of_ros2(body), 0)
            writer.finish()
        return path

    def bag(self):
        path = self.folder / "ros1.bag"
        with Writer1(path) as writer:
            connection = writer.add_connection("/tactile", "std_msgs/msg/Float32MultiArray", typestore=get_typestore(Stores.ROS1_NOETIC))
            for number, row in enumerate(ROWS):
                writer.write(connection, START + number * 10**7, array(row))
        return path

    def folder_of_ros2(self):
        path = self.folder / "ros2"
        with Writer2(path, version=9) as writer:
            connection = writer.add_connection("/tactile", "std_msgs/msg/Float32MultiArray", typestore=get_typestore(Stores.ROS2_HUMBLE))
            for number, row in enumerate(ROWS):
                writer.write(connection, START + number * 10**7, of_ros2(array(row)))
        return path

    def said(self, lines):
        """What monitor says of lines of numbers, but for when it said so."""
        profile = self.folder / "pad.toml"
        profile.write_text(PROFILE)
        command = [os.environ["TACTEL_PROGRAM"], "monitor", "--source", "csv:-", "--quiet", "--profile", profile, "--rest", "--alarm", "0.06", "--stresses", "--late", "100"]
        done = subprocess.run(command, input="\n".join(lines) + "\n", capture_output=True, text=True, check=True)
        return [{key: value for key, value in json.loads(line).items() if key not in ("arrival", "latency_us")} for line in done.stdout.splitlines()]

    def test_bags_are_the_same_numbers_by_csv(self):
        wanted = self.said(["time,c0,c1,c2,c3,c4,c5"] + [",".join(map(str, [f"{START // 10**9}.{number:02}", *row])) for number, row in enumerate(ROWS)])
        self.assertEqual(len(wanted), len(ROWS))
        self.assertEqual(len(wanted[0]["stresses"]), 3)
        for path in (self.mcap(*map(array, ROWS)), self.bag(), self.folder_of_ros2()):
            with self.subTest(path.name):
                self.assertEqual(self.said(files.lines(path, "/tactile", "data")), wanted)

    def test_arrays_of_objects_with_the_time_of_their_maker(self):
        frame_id = b"skin\0"
        body = struct.pack("<iII5s3xI", 17, 250, len(frame_id), frame_id, 2) + struct.pack("<3fB3x3fB", 1, 2, 3, 9, 4, 5.5, 6, 9)
        path = self.mcap(body, body[:-9], schema=("skin_msgs/msg/Skin", SKIN))  # the second one is cut
        with self.assertWarnsRegex(UserWarning, "1 of 2 messages are left out"):
            self.assertEqual(list(files.lines(path, "/tactile", "taxels.*.[x,y,z]")), ["time,c0,c1,c2,c3,c4,c5", "17.000000250,1.0,2.0,3.0,4.0,5.5,6.0"])

    def test_what_is_no_bag_ends_in_words(self):
        for name in ("empty.bag", "empty"):
            path = self.folder / name
            path.write_bytes(b"#ROSBAG V2.0\n" * 9) if path.suffix else path.mkdir()
            with self.subTest(name), contextlib.redirect_stderr(io.StringIO()) as said:
                self.assertEqual(files.main(["read", str(path), "--topic", "/tactile", "--values", "data"]), 2)
                self.assertRegex(said.getvalue(), "^tactel.mcap: .*empty")
        with self.assertRaisesRegex(InputError, "no message of /skin; .*: /tactile"):
            list(files.lines(self.bag(), "/skin", "data"))
        schema = ("std_msgs/msg/Float32MultiArray", "std_msgs/MultiArrayLayout layout\nfloat32[] data")  # a part of the definition is missing
        with self.assertRaises(InputError):
            list(files.lines(self.mcap(array([1]), schema=schema), "/tactile", "data"))


if __name__ == "__main__":
    unittest.main()
