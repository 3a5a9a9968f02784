# SPDX-License-Identifier: Apache-2.0
"""tactel.import_network: graphs as exporters write them, made by onnx.helper; the truth is onnx's own evaluator."""
import contextlib
import io
import pathlib
import tempfile
import unittest

import numpy as np
import onnx
from onnx import helper, numpy_helper
from onnx.reference import ReferenceEvaluator
from tactel import InputError, Network
from tactel import import_network as own

PROFILE = """[device]
name = "two tactels"
[format]
kind = "csv"
channels = 4
[channels]
normal = [0, 1]
shear = [2, 3]
[calibration]
offset = 0
gain = 1
"""


class Graph:
    """Grows by one operation at a time."""

    def __init__(self, inputs, batch="N"):
        self.random, self.width, self.inputs, self.batch = np.random.default_rng(3), inputs, inputs, batch
        self.nodes, self.constants, self.value = [], [], "frame"

    def constant(self, values):
        self.constants.append(numpy_helper.from_array(np.asarray(values), f"constant{len(self.constants)}"))
        return self.constants[-1].name

    def numbers(self, *shape):
        return self.random.uniform(-0.9, 1.1, shape).astype(np.float32)

    def add(self, kind, *inputs, **attributes):
        self.nodes.append(helper.make_node(kind, list(inputs) or [self.value], [f"value{len(self.nodes)}"], **attributes))
        self.value = self.nodes[-1].output[0]
        return self

    def dense(self, outputs):
        self.add("Gemm", self.value, self.constant(self.numbers(outputs, self.width)), self.constant(self.numbers(outputs)), transB=1)
        self.width = outputs
        return self

    def by(self, kind, values, first=True):
        names = [self.value, self.constant(np.asarray(values, np.float32))]
        return self.add(kind, *(names if first else names[::-1]))

    def normalized(self):
        mean = [self.constant(self.numbers(self.width)) for _ in range(3)]
        return self.add("BatchNormalization", self.value, *mean, self.constant(abs(self.numbers(self.width))), epsilon=0.01)

    def reshape(self, *extents):
        return self.add("Reshape", self.value, self.constant(np.array(extents, np.int64)))

    def finished(self):
        shapes = {name: helper.make_tensor_value_info(name, 1, extents) for name, extents in [("frame", [self.batch, self.inputs]), (self.value, [None, None])]}
        graph = helper.make_graph(self.nodes, "own", [shapes["frame"]], [shapes[self.value]], self.constants)
        return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)


def end(graph):
    return graph.dense(1).add("Sigmoid")


class ImportNetwork(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.path = self.folder / "own.onnx"

    def take(self, graph):
        onnx.save(graph.finished(), self.path)
        return own.network(self.path, axes=1)

    def same(self, graph):
        """Within 2e-6: fp32, 1e-7 for each of some ten sums."""
        made, frames = self.take(graph), np.random.default_rng(5).normal(0, 0.7, (200, graph.inputs)).astype(np.float32)
        truth = np.ravel(ReferenceEvaluator(onnx.load(self.path)).run(None, {"frame": frames})[0])
        self.assertGreater(np.ptp(truth), 0.05)
        np.testing.assert_allclose(made(frames), truth, rtol=0, atol=2e-6)

    def refused(self, graph, words):
        with self.assertRaisesRegex(InputError, words):
            self.take(graph)

    def test_every_activation_and_slope(self):
        for kind in "Sigmoid", "Tanh", "Relu":
            self.same(end(Graph(8).dense(7).add(kind).dense(5).add(kind)))
            self.same(end(Graph(8).dense(7).add(kind)))
        self.same(end(Graph(8).dense(7).add("Sigmoid").dense(5).add("Tanh")))
        for slope in 0.01, 0.3, -0.2:
            self.same(end(Graph(8).dense(7).add("LeakyRelu", alpha=slope).dense(5).add("LeakyRelu", alpha=slope)))
        # the slope of tactel's own rectifiers takes no second neuron
        self.assertEqual(self.take(end(Graph(8).dense(7).add("LeakyRelu", alpha=0.01))).topology, "8-7-1_leaky-relu")
        self.assertEqual(self.take(end(Graph(8).dense(7).add("LeakyRelu", alpha=0.3))).topology, "8-14-1_leaky-relu")

    def test_constants_and_normalization_go_into_the_layers(self):
        six = np.arange(1, 7)[None] / 3
        self.same(end(Graph(6).by("Sub", six).by("Div", six).dense(5).by("Add", six[:, :5]).add("Tanh")))
        self.same(end(Graph(6).by("Div", 2).by("Sub", 0.1, False).dense(5).add("Tanh")))
        self.same(end(Graph(6).dense(4).add("Tanh").by("Mul", six[:, :4]).dense(3)))
        self.same(Graph(6).add("Flatten").dense(4).add("Tanh").dense(1).add("Tanh").by("Mul", 0.5).by("Add", 0.5))
        self.same(end(Graph(6).normalized().dense(5).normalized().add("Tanh").normalized()))

    def test_what_moves_no_number_is_left_out(self):
        def answers(graph):
            return self.take(end(graph))(np.linspace(-1, 1, 12, dtype=np.float32).reshape(3, 4))

        plain = answers(Graph(4).dense(3).add("Tanh"))
        for graph in (Graph(4).add("Cast", to=1).dense(3).add("Tanh").add("Cast", to=11), Graph(4).reshape(-1, 4).dense(3).add("Tanh").reshape(0, 3),
                      Graph(4).add("Flatten").dense(3).reshape(1, -1).add("Tanh"), Graph(4, batch=2).reshape(2, -1).dense(3).add("Tanh")):
            np.testing.assert_array_equal(answers(graph), plain)
        view = Graph(4).dense(3).add("Tanh")  # x.view(x.size(0), -1), as exporters of old write it
        chain = view.value
        view.add("Shape").add("Gather", view.value, view.constant(np.int64(0)), axis=0).add("Unsqueeze", view.value, view.constant(np.array([0])))
        view.add("Concat", view.value, view.constant(np.array([-1])), axis=0).add("Reshape", chain, view.value)
        np.testing.assert_array_equal(answers(view), plain)
        turned = Graph(4)
        first = turned.numbers(3, 4), turned.constant(turned.numbers(3))
        turned.add("Transpose", turned.constant(first[0]), perm=[1, 0]).add("Gemm", "frame", turned.value, first[1]).add("Tanh")
        turned.width = 3
        np.testing.assert_array_equal(answers(turned), plain)

    def test_what_is_no_such_chain_is_named(self):
        silu = Graph(4).dense(3)
        before = silu.value
        silu.add("Sigmoid")
        self.refused(end(silu.add("Mul", before, silu.value)), "the activation SiLU")
        tanh = Graph(4).dense(3).add("Tanh")
        for graph, words in [
                (Graph(4).dense(3).add("Softmax"), "the operation Softmax; must be a chain of dense layers"),
                (Graph(4).dense(3).add("Tanh").dense(1), "a linear output; must end in one output through a sigmoid"),
                (Graph(4).dense(3).add("Tanh").dense(1).add("Relu"), "an output that is no sigmoid"),
                (Graph(4).dense(3).add("Tanh").dense(2).add("Sigmoid"), "one output through a sigmoid"),
                (end(Graph(4)), "1 dense layers"),
                (end(Graph(4).dense(3).add("Relu").dense(3).add("Tanh")), "a rectifier beside another"),
                (end(Graph(4).dense(400).add("Tanh")), "4-400-1"),
                (end(Graph(4).add("Tanh")), "Tanh without a dense layer before it"),
                (end(Graph(4).dense(3).by("Add", np.ones((1, 2)))), "layers that do not fit each other|a constant of shape"),
                (end(tanh.add("Add", tanh.value, "value0")), "a graph with branches at its Add"),
                (end(Graph(4).add("Flatten", axis=0).dense(3).add("Tanh")), "a Flatten along another axis"),
                (end(Graph(4).dense(3).reshape(3, -1).add("Tanh")), "a Reshape of a frame"),
                (end(Graph(4).add("Cast", to=10).dense(3).add("Tanh")), "a Cast to float16"),
        ]:
            self.refused(graph, words)

    def test_files_that_are_no_network(self):
        onnx.save(end(Graph(4).dense(3).add("Tanh")).finished(), self.path)
        whole = self.path.read_bytes()
        for size in range(0, len(whole), 7):
            self.path.write_bytes(whole[:size])
            with self.assertRaises(InputError, msg=str(size)):
                own.network(self.path, axes=1)
        with self.assertRaisesRegex(InputError, "none.onnx: network: cannot be read"):
            own.network(self.folder / "none.onnx")
        large = Graph(1100).dense(1000)
        self.refused(end(large.add("Tanh")), "bytes; must be at most|constants of 1101")

    def test_numbers_in_a_file_beside_it(self):
        model = end(Graph(4).dense(3).add("Tanh")).finished()
        frames = np.eye(4, dtype=np.float32)
        expected = np.ravel(ReferenceEvaluator(model).run(None, {"frame": frames})[0])
        onnx.save(model, self.path, save_as_external_data=True, location="own.data", size_threshold=0)
        np.testing.assert_allclose(own.network(self.path, axes=1)(frames), expected, atol=2e-6)
        (self.folder / "own.data").unlink()
        with self.assertRaisesRegex(InputError, "external_data=False"):
            own.network(self.path, axes=1)
        place, = [entry for entry in model.graph.initializer[0].external_data if entry.key == "location"]
        place.value = "../../etc/passwd"
        self.path.write_bytes(model.SerializeToString())
        with self.assertRaises(InputError):
            own.network(self.path, axes=1)

    def run_main(self, *words):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = own.main([str(self.path), "--output", str(self.folder / "new.onnx"), *map(str, words)])
        return code, out.getvalue(), err.getvalue()

    def test_the_command_judges_by_frames(self):
        graph = end(Graph(4).dense(6).add("Tanh"))
        onnx.save(graph.finished(), self.path)
        frames = np.array([[-0.5, -1, 0.25, 0.5], [-2, -1, 1, -0.5], [-0.1, 0, 0.05, 0]], np.float32)
        truth = np.ravel(ReferenceEvaluator(graph.finished()).run(None, {"frame": frames / 2})[0])  # it divides stresses by 2 MPa
        lines = self.folder / "frames.csv"

        def write(error=0.0):
            lines.write_text("\r\n".join(",".join(map(repr, map(float, [*frame, s + error]))) for frame, s in zip(frames, truth)))

        write()
        profile = self.folder / "p.toml"
        profile.write_text(PROFILE)
        code, out, err = self.run_main("--frames", lines, "--largest-stress", 2, "--profile", profile)
        self.assertEqual((code, err), (0, ""))
        self.assertRegex(out, r"new.onnx: 4-6-1, within .* on the 3 frames of ")
        made = Network.load(self.folder / "new.onnx")
        np.testing.assert_allclose(made(frames), truth, atol=1e-6)
        (self.folder / "new.onnx").unlink()
        code, _, err = self.run_main("--frames", lines)
        self.assertEqual(code, 4)
        self.assertIn("was not written; give the scaling", err)
        write(2e-4)
        code, _, err = self.run_main("--frames", lines, "--largest-stress", 2)
        self.assertEqual(code, 4)
        self.assertIn("S differs by 0.0002", err)
        self.assertFalse((self.folder / "new.onnx").exists())

    def test_the_command_names_wrong_input(self):
        onnx.save(end(Graph(4).dense(6).add("Tanh")).finished(), self.path)
        wrong = self.folder / "wrong.csv"
        for text, words in [("1,2,3,4,0.5\n1,2,3,4\n", "wrong.csv:2: fields: 4; must be 5"), ("1,2,x,4,0.5\n", "wrong.csv:1: column 3"),
                            ("1,2,nan,4,0.5\n", "wrong.csv:1: column 3"), ("\n", "frames: none")]:
            wrong.write_text(text)
            code, _, err = self.run_main("--frames", wrong)
            self.assertEqual(code, 2, text)
            self.assertIn(words, err)
        for words, said in [(["--frames", self.folder / "no.csv"], "no.csv: cannot be read"), (["--largest-stress", 0], "largest_stress"),
                            (["--history", 3], "4 inputs for a history of 3 frames")]:
            code, _, err = self.run_main(*words)
            self.assertEqual(code, 2)
            self.assertIn(said, err)
        wide = self.folder / "wide.toml"
        wide.write_text(PROFILE.replace("[0, 1]", "[0, 1, -1]").replace("[2, 3]", "[2, 3, -1]"))
        code, _, err = self.run_main("--profile", wide)
        self.assertEqual(code, 2)
        self.assertIn("a network of 6 inputs", err)

    def test_rest_and_history_are_kept(self):
        onnx.save(end(Graph(4).dense(6).add("Tanh")).finished(), self.path)
        code, _, err = self.run_main("--scaling", "rest", "--target", "slid")
        self.assertEqual((code, err), (0, ""))
        rest = Network.load(self.folder / "new.onnx").estimator
        code, _, err = self.run_main("--history", "2:3", "--history-change", "0.2", "--scaling", "frame")
        self.assertEqual((code, err), (0, ""))
        self.assertIsNotNone(rest)


if __name__ == "__main__":
    unittest.main()
