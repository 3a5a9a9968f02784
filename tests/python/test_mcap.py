# SPDX-License-Identifier: Apache-2.0
"""tactel.mcap: files are read by the mcap package, and come back as the lines that were written."""
import contextlib
import io
import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import warnings
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
        with files.Writer(self.path, force=True) as writer:
            for line in lines:
                writer.add(line + "\n")

    def foreign(self, *texts, topic="/skin", encoding="json", schema=None, metadata={}):
        """A file of another program: a message each 10 ms from a day of 2026 on."""
        with open(self.path, "wb") as file:
            writer = Writer(file)
            writer.start()
            channel = writer.register_channel(topic, encoding, writer.register_schema(*schema) if schema else 0, metadata)
            for number, text in enumerate(texts):
                writer.add_message(channel, 1_795_000_000 * 10**9 + number * 10**7, text, 0)
            writer.finish()

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
        for lines, words in (([ANSWERS[0], "{"], "line 2: text"), (["a,b", "1,2", "x,y"], "line 3: text"), (["a,b", "1,2", "1,2,3"], "line 3: fields"), (['{"frame": 1}'], "line 1: arrival"),
                             (["time,a", "-1,2"], "line 2: time"), (["time,a", "nan,2"], "line 2: time"), (["time,a", "1.9e10,2"], "line 2: time"),
                             (["1,inf"], "line 1: text"), (["1,1e999"], "line 1: text"), (['{"arrival": NaN}'], "line 1: text"), (['{"a":' * 10**5], "line 1: text"), (["1" * 2**21], "line 1: line")):
            with self.subTest(words), self.assertRaisesRegex(InputError, words):
                self.write(lines)

    def test_numbers_of_any_program_become_json(self):
        self.write(["+1.5,007", ".5,1.", "1_000,nan", "-0,1e-7"])
        self.assertEqual([values["values"] for _, _, _, values in self.messages()], [[1.5, 7], [0.5, 1], [1000, None], [0, 1e-7]])
        self.assertEqual(list(files.lines(self.path)), ["1.5,7.0", "0.5,1.0", "1000.0,nan", "-0,1e-7"])
        self.write(["a;b", "1,5;2", "# a remark", "3;-4,25"])
        self.assertEqual(list(files.lines(self.path)), ["a,b", "1.5,2", "3,-4.25"])
        with self.assertWarnsRegex(UserWarning, "'begins' above is no header"):
            self.write(["begins", "1,2", "3,4"])
        self.assertEqual(list(files.lines(self.path)), ["1,2", "3,4"])

    def test_times_of_this_century_keep_their_digits(self):
        self.write(["\ufefftime,a", "1795000000.123456789,1", "17999999999.5,2"])
        self.assertEqual([stamp for _, _, stamp, _ in self.messages()], [1795000000123456789, 17999999999500000000])
        self.assertEqual(list(files.lines(self.path))[1], "1795000000.123456789,1")
        self.write(['{"arrival": 1795000000.123456789}'])
        self.assertEqual(self.messages()[0][2], 1795000000123456789)

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

    def test_a_file_is_not_overwritten(self):
        self.path.write_text("precious")
        with self.assertRaisesRegex(InputError, "exists; .*--force"):
            files.Writer(self.path)
        with files.Writer(self.path, force=True), self.assertRaises(InputError):
            list(files.lines(self.path))
        self.assertEqual(self.path.read_text(), "precious")  # before the first line
        self.path.unlink()
        with files.Writer(self.path):
            pass
        self.assertFalse(self.path.exists())

    def test_what_is_whole_of_a_file_is_read(self):
        writer = files.Writer(self.path)
        for number in range(3):
            writer.add(f"{number},7")
            writer.flush()
        begun = self.path.read_bytes()
        writer.add("3,7")  # not in the file yet
        with self.assertWarnsRegex(UserWarning, "has no end"):
            self.assertEqual(list(files.lines(self.path)), ["0,7", "1,7", "2,7"])
        with writer:
            pass
        self.assertEqual(list(files.lines(self.path)), ["0,7", "1,7", "2,7", "3,7"])
        self.path.write_bytes(begun[:-20])  # in the third chunk, or its index
        with self.assertWarns(UserWarning):
            self.assertIn(list(files.lines(self.path)), (["0,7", "1,7"], ["0,7", "1,7", "2,7"]))

    def test_damaged_files_end_in_words(self):
        self.write(NUMBERS + ANSWERS)
        whole = self.path.read_bytes()
        for place in range(8, len(whole), 5):
            self.path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x55]) + whole[place + 1:])
            with warnings.catch_warnings(), contextlib.suppress(InputError):
                warnings.simplefilter("ignore")
                list(files.lines(self.path))

    def test_strange_messages_are_left_out(self):
        good = b'{"values": [1, 2]}'
        for bad in (b"null", b"true", b"5", b"[1]", b"{}", b'{"values": "abc"}', b'{"values": ["1\\nslides", 2]}', b'{"values": [true, 2]}', b'{"values": []}',
                    b'{"time": "\\u001b[31m", "values": [1, 2]}', b'{"time": [1], "values": [1]}', b'{"time": {}, "values": [1, 2]}', b"\xff\xfe", b"", b'{"values": ' + b"[" * 10**5):
            self.foreign(good, bad, good, topic=files.FRAMES, metadata={"names": "a\nslides,\x1b[31m"})
            with self.subTest(bad[:40]), self.assertWarnsRegex(UserWarning, "1 of 3 messages are left out; the first, message 2 of /tactel/frames"):
                self.assertEqual(list(files.lines(self.path)), ["c0,c1", "1,2", "1,2"])
            if b"time" not in bad:
                self.foreign(bad)
                with self.subTest(bad[:40]), self.assertRaises(InputError):
                    list(files.lines(self.path, "/skin", "values"))

    def test_an_answer_is_a_line(self):
        self.foreign(b'{"arrival": 1,\n "text": "a\\nb"}', b'{"arrival": 1}\x1b[31m\n{"arrival": 2}', topic=files.ANSWERS)
        with self.assertWarnsRegex(UserWarning, "1 of 2"):
            self.assertEqual(list(files.lines(self.path)), ['{"arrival": 1,  "text": "a\\nb"}'])

    def test_numbers_that_are_none_are_nan(self):
        self.foreign(b'{"data":[1,2.50,3]}', b'{"data":[1,NaN,null]}')
        self.assertEqual(list(files.lines(self.path, "/skin", "data"))[1:], ["1795000000.000000000,1,2.50,3", "1795000000.010000000,1,nan,nan"])

    def test_paths_go_into_arrays_of_objects(self):
        taxel = [{"name": "t", "z": 10 * k + 3, "y": 10 * k + 2, "x": 10 * k + 1} for k in range(4)]
        self.foreign(json.dumps({"sensors": [{"pos": 1, "taxels": taxel[:2]}, {"pos": 2, "taxels": taxel[2:]}]}).encode())
        for path, row in (("sensors.*.taxels.*.[x,y,z]", "1,2,3,11,12,13,21,22,23,31,32,33"), ("sensors.taxels.[x,y,z]", "1,2,3,11,12,13,21,22,23,31,32,33"),
                          ("sensors.1.taxels.*.z", "23,33"), ("sensors.*.[pos,taxels.0]", None), ("sensors.*.pos", "1,2"), ("sensors.taxels", None), ("sensors.3.pos", None)):
            with self.subTest(path):
                if row:
                    self.assertEqual(list(files.lines(self.path, "/skin", path))[1], "1795000000.000000000," + row)
                else:
                    with self.assertRaises(InputError):
                        list(files.lines(self.path, "/skin", path))
        for wrong in ("", "a..b", "a[x]", "[]"):
            with self.subTest(wrong), self.assertRaisesRegex(InputError, "values: "):
                list(files.lines(self.path, "/skin", wrong or "."))

    def test_the_time_is_the_makers(self):
        for text, name, stamp in (('"header": {"stamp": {"sec": 17, "nanosec": 5000000}}, "time": 3', None, "17.005000000"), ('"time": 3.250', None, "3.250"), ('"time": 1795000000000', None, "1795000000.000000000"),
                                  ('"header": {"stamp": {"secs": 17, "nsecs": 1}}', "header.stamp", "17.000000001"), ('"time": 3', "log", "1795000000.000000000"), ('"at": 4', "at", "4")):
            self.foreign(f'{{{text}, "data": [1]}}'.encode())
            with self.subTest(text):
                self.assertEqual(list(files.lines(self.path, "/skin", "data", name))[1], stamp + ",1")

    def test_topics_of_the_file_are_named(self):
        self.foreign(b"{}", topic="/robot/skin")
        with self.assertRaisesRegex(InputError, "no message of /skin; .*: /robot/skin"):
            list(files.lines(self.path, "/skin", "data"))
        self.foreign(b"1", topic="/skin", encoding="protobuf")
        with self.assertRaisesRegex(InputError, "/skin: messages in protobuf"):
            list(files.lines(self.path, "/skin", "data"))
        with mock.patch.dict("sys.modules", {"mcap_ros2.decoder": None}):
            self.foreign(b"1", topic="/skin", encoding="cdr")
            with self.assertRaisesRegex(InputError, "pip install mcap-ros2-support"):
                list(files.lines(self.path, "/skin", "data"))
        with mock.patch.dict("sys.modules", {"rosbags.highlevel": None}), self.assertRaisesRegex(InputError, "pip install rosbags"):
            list(files.lines(self.path.with_suffix(".bag"), "/skin", "data"))

    def run_main(self, *words):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = files.main([str(word) for word in words])
        return code, out.getvalue(), err.getvalue()

    def test_a_live_recording_survives(self):
        """Lines as of a sensor, one of them bad; then a signal. What came is in the file, after SIGKILL but for the last second."""
        for ended in (signal.SIGTERM, signal.SIGKILL):
            self.path.unlink(missing_ok=True)
            with self.subTest(ended), subprocess.Popen([sys.executable, "-m", "tactel.mcap", "write", self.path], stdin=subprocess.PIPE, stderr=subprocess.PIPE) as program:
                program.stdin.write(b"\xff\noops,1\n")
                sent, at = 0, {}
                begin = None
                while begin is None or time.monotonic() < begin + 4.2:
                    program.stdin.write(b"%d,7\n" % sent)
                    program.stdin.flush()
                    at[sent], sent = time.monotonic(), sent + 1
                    time.sleep(0.001)
                    if begin is None and self.path.exists() and self.path.stat().st_size > 0:
                        begin = time.monotonic()
                end = time.monotonic()
                program.send_signal(ended)
                program.wait()
                said = program.communicate()[1].decode()
            code, out, err = self.run_main("read", self.path)
            rows = out.splitlines()
            self.assertEqual(code, 0, err)
            self.assertEqual(rows, [f"{k},7" for k in range(len(rows))])
            if ended == signal.SIGTERM:
                self.assertEqual((program.returncode, len(rows), err), (130, sent, ""))
                self.assertRegex(said, "^tactel.mcap: 2 lines are left out; the first, ")
            else:
                self.assertIn("has no end", err)
                # a second, and what the reading process was late on a busy machine
                self.assertLess(end - at.get(len(rows), end), 2.5)

    def test_as_a_program(self):
        for text, code, out, err in (("\n".join(NUMBERS) + "\n", 0, NUMBERS, ""), ("1,2\n3,4", 0, ["1,2"], "the last line has no end"), ("1,2\nbad\n3,4\n", 0, ["1,2", "3,4"], "1 lines are left out; the first, line 2: text")):
            self.path.unlink(missing_ok=True)
            with self.subTest(text):
                done = subprocess.run([sys.executable, "-m", "tactel.mcap", "write", self.path], input=text, capture_output=True, text=True)
                self.assertEqual(done.returncode, code, done.stderr)
                self.assertIn(err, done.stderr)
                self.assertEqual(self.run_main("read", self.path)[1].splitlines(), out)
        self.assertIn("tactel.mcap: none.mcap", self.run_main("read", "none.mcap")[2])
        self.assertIn("exists; give a new file, or --force", self.run_main("write", self.path)[2])
        self.assertIn("none/a.mcap: No such file or directory; a file that can", self.run_main("write", self.path.parent / "none/a.mcap")[2])

    def test_without_input_it_ends(self):
        done = subprocess.run(f"exec {sys.executable} -m tactel.mcap write '{self.path}' <&-", shell=True, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("Bad file descriptor", done.stderr)

    def test_a_full_disk_leaves_what_is_whole(self):
        text = "".join(f"{k * 0.1234567:.9f},{k * 7919 % 10007 / 7:.12f}\n" for k in range(4000))
        done = subprocess.run(f"ulimit -f 16; {sys.executable} -m tactel.mcap write '{self.path}'", shell=True, input=text, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (2, f"tactel.mcap: {self.path}: File too large; what is whole of it can be read\n"))
        code, out, err = self.run_main("read", self.path)
        self.assertEqual((code, out.splitlines()), (0, text.splitlines()[:len(out.splitlines())]), err)


if __name__ == "__main__":
    unittest.main()
