# SPDX-License-Identifier: Apache-2.0
"""tactel.mcap: files are read by the mcap package, and come back as the lines that were written."""
import contextlib
import io
import json
import pathlib
import tempfile
import unittest
from unittest import mock

import tactel.mcap as files
from mcap.reader import make_reader
from mcap.writer import Writer
from tactel import InputError

ANSWERS = ['{"frame": 0, "arrival": 0, "slip_index": null}', '{"frame": 1, "arrival": 0.0100001, "slip_index": 0.33333334, "stresses": [[-0.1, -0.2], [1e-05, 0]]}']
NUMBERS = ["time,a,b", "0,1000,1001.50", "0.010,-3,1e-7", "0.020,0,0.1"]


class Mcap(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name) / "a.mcap"

    def write(self, lines):
        with files.Writer(self.path) as writer:
            for line in lines:
                writer.add(line + "\n")

    def messages(self):
        with open(self.path, "rb") as file:
            return [(schema.name, channel.topic, message.log_time, json.loads(message.data)) for schema, channel, message in make_reader(file).iter_messages()]

    def test_answers_come_back(self):
        self.write(ANSWERS)
        self.assertEqual(list(files.lines(self.path)), ANSWERS)
        self.assertEqual(self.messages(), [("tactel.Answer", "/tactel/answers", 0, json.loads(ANSWERS[0])), ("tactel.Answer", "/tactel/answers", 10000100, json.loads(ANSWERS[1]))])

    def test_numbers_come_back_digit_by_digit(self):
        self.write(NUMBERS)
        self.assertEqual(list(files.lines(self.path)), NUMBERS)
        self.assertEqual(self.messages()[1], ("tactel.Frame", "/tactel/frames", 10**7, {"time": 0.01, "values": [-3, 1e-7]}))
        self.write(["1,2", "", "3,4.0"])  # no header, no times
        self.assertEqual(list(files.lines(self.path)), ["1,2", "3,4.0"])

    def test_an_array_of_another_topic_is_lines_of_numbers(self):
        with open(self.path, "wb") as file:
            writer = Writer(file)
            writer.start()
            channel = writer.register_channel("/skin", "json", 0)
            writer.add_message(channel, 1_500_000_000, b'{"msg": {"data": [[1, 2.50], [3]]}}', 0)
            writer.finish()
        self.assertEqual(list(files.lines(self.path, "/skin", "msg.data")), ["time,c0,c1,c2", "1.500000000,1,2.50,3"])
        with self.assertRaisesRegex(InputError, "message 1 of /skin: without data"):
            list(files.lines(self.path, "/skin", "data"))
        with self.assertRaisesRegex(InputError, "no message of /tactel/answers or /tactel/frames"):
            list(files.lines(self.path))

    def test_stresses_of_answers_are_lines_of_numbers(self):
        self.write(ANSWERS[1:])
        self.assertEqual(list(files.lines(self.path, files.ANSWERS, "stresses"))[1], "0.010000100,-0.1,-0.2,1e-05,0")

    def test_wrong_lines_are_named(self):
        for lines, words in (([ANSWERS[0], "{"], "line 2: text"), (["a,b", "1,2", "x,y"], "line 3: text"), (["a,b", "1,2,3"], "line 2: fields"), (['{"frame": 1}'], "line 1: arrival"),
                             (["time,a", "-1,2"], "line 2: time"), (["1,nan"], "line 1: values")):
            with self.subTest(words), self.assertRaisesRegex(InputError, words):
                self.write(lines)

    def test_a_file_of_another_kind_is_refused(self):
        self.path.write_bytes(b"no MCAP at all, but long enough to be one" * 3)
        with self.assertRaisesRegex(InputError, "a file of MCAP"):
            list(files.lines(self.path))
        with self.assertRaisesRegex(InputError, "a file of MCAP"):
            list(files.lines(self.path.parent / "none.mcap"))
        self.write(NUMBERS)
        self.path.write_bytes(self.path.read_bytes()[:150])
        with self.assertRaises(InputError):
            list(files.lines(self.path))

    def test_as_a_program(self):
        out, err = io.StringIO(), io.StringIO()
        with mock.patch("sys.stdin", io.StringIO("\n".join(NUMBERS) + "\n")):
            self.assertEqual(files.main(["write", str(self.path)]), 0)
        with contextlib.redirect_stdout(out):
            self.assertEqual(files.main(["read", str(self.path)]), 0)
        self.assertEqual(out.getvalue().splitlines(), NUMBERS)
        with contextlib.redirect_stderr(err):
            self.assertEqual(files.main(["read", "none.mcap"]), 2)
        self.assertIn("tactel.mcap: none.mcap", err.getvalue())


if __name__ == "__main__":
    unittest.main()
