# SPDX-License-Identifier: Apache-2.0
"""Takes a network that another program trained, as ONNX: dense layers become one of tactel's networks. Needs the package onnx of PyPI.

    python -m tactel.import_network own.onnx --scaling frame --frames own.csv --output slip.onnx

Gemm or MatMul with Sigmoid, Tanh, Relu or LeakyRelu behind each; the last is one output through a sigmoid, or 1/2 + 1/2 tanh.
Constants that are added, subtracted, multiplied or divided, and BatchNormalization, go into the next layer. What moves no number
(Flatten, Reshape, x.view(x.size(0), -1), Dropout, ...) is left out. The judge is onnx's own evaluator, on random frames or --frames."""

import argparse
import os
import sys

import numpy as np

from . import InputError, Network, open_sensor
from ._calls import exit_code, input_error

LARGEST_DIFFERENCE = 1e-4  # fp32 in both programs, in sums of other orders: a misread operation errs by far more
RANDOM_FRAMES = 1000
MOST_BYTES, MOST_NUMBERS, MOST_OPERATIONS = 4 << 20, 1 << 20, 1000
A_CHAIN = "must be a chain of dense layers (Gemm or MatMul) with Sigmoid, Tanh, Relu or LeakyRelu behind each"
# Of constants alone, as exporters leave them in front of a weight or of the extents of a Reshape.
FOLDED = {"Cast", "Concat", "Gather", "Identity", "Reshape", "Slice", "Squeeze", "Transpose", "Unsqueeze"}


def _onnx():
    try:
        import onnx.checker
        import onnx.numpy_helper
        import onnx.reference
    except ImportError:
        raise input_error("onnx", "not installed", "install it: pip install onnx") from None
    return onnx


class _Refused(Exception):
    def __init__(self, problem, fix=A_CHAIN):
        super().__init__(problem)
        self.problem, self.fix = problem, fix


def _load(path):
    """The model, its numbers in it, checked by onnx."""
    onnx = _onnx()
    try:
        if os.path.getsize(path) > MOST_BYTES:
            raise _Refused(f"{os.path.getsize(path)} bytes", f"must be at most {MOST_BYTES}")
        model = onnx.load(path, load_external_data=False)
        for tensor in model.graph.initializer:
            for entry in tensor.external_data:
                beside = os.path.join(os.path.dirname(os.fspath(path)), entry.value)
                if entry.key == "location" and os.path.basename(entry.value) == entry.value and not os.path.isfile(beside):
                    raise _Refused(f"numbers in {entry.value!r}, which is not there",
                                   "must have that file beside it; torch.onnx.export(..., external_data=False) writes one file")
        _check_size(model.graph.initializer)
        onnx.load_external_data_for_model(model, os.path.dirname(os.path.abspath(path)))
        onnx.checker.check_model(model)
    except OSError as error:
        raise _Refused(f"cannot be read ({error.strerror})", "must be an ONNX file") from None
    except (InputError, _Refused):
        raise
    except Exception as error:  # of protobuf and of onnx.checker, which have no common kind
        raise _Refused("no ONNX file that is whole: " + " ".join(str(error).split())[:200]) from None
    return model


def _check_size(tensors):
    numbers = sum(int(np.prod([max(0, extent) for extent in tensor.dims], dtype=float)) for tensor in tensors)
    if numbers > MOST_NUMBERS:
        raise _Refused(f"constants of {numbers} numbers", f"must have at most {MOST_NUMBERS}")


class _Chain:
    """Layers, one operation after the other. What is not yet in a layer: matrix @ x + shift, x the frame or the answers of the last
    layer; matrix None: scale * x + shift, number by number."""

    def __init__(self, model):
        onnx = _onnx()
        graph = model.graph
        self.constants = {tensor.name: onnx.numpy_helper.to_array(tensor) for tensor in graph.initializer}
        inputs = [value for value in graph.input if value.name not in self.constants]
        if len(inputs) != 1 or len(graph.output) != 1:
            raise _Refused(f"{len(inputs)} inputs and {len(graph.output)} outputs", "must be a chain from one input to one output")
        if len(graph.node) > MOST_OPERATIONS:
            raise _Refused(f"{len(graph.node)} operations", f"must have at most {MOST_OPERATIONS}")
        self.value, self.before = inputs[0].name, None
        extents = inputs[0].type.tensor_type.shape.dim
        self.batch = extents[0].dim_value if extents else 0  # 0: any
        self.layers, self.matrix, self.scale, self.shift, self.spent = [], None, np.ones(1), np.zeros(1), 0
        for node in graph.node:
            if node.domain not in ("", "ai.onnx"):
                raise _Refused(f"the operation {node.op_type} of {node.domain}")
            self._apply(node)
        if self.value != graph.output[0].name:
            raise _Refused("an output that is not the chain's end")
        self._finish()

    def _finish(self):
        if not self.layers:
            raise _Refused("no dense layer with an activation" if self.matrix is None else "a linear output", _SIGMOID)
        weights, bias, kind, slope = self.layers[-1]
        if self.matrix is None and kind == "tanh" and self.scale.size == 1 and self.scale[0] == self.shift[0] == 0.5:
            self.layers[-1] = (2 * weights, 2 * bias, "sigmoid", slope)  # 1/2 + 1/2 tanh z = sigmoid(2 z)
        elif self.matrix is not None:
            raise _Refused("a linear output", _SIGMOID)
        elif (self.scale != 1).any() or (self.shift != 0).any() or kind != "sigmoid":
            raise _Refused(f"an output that is no sigmoid ({kind})", _SIGMOID)

    def _apply(self, node):
        kind, inputs = node.op_type, [name for name in node.input if name]
        values = {attribute.name: _onnx().helper.get_attribute_value(attribute) for attribute in node.attribute}
        if kind == "Constant" and "value" in values:
            _check_size([values["value"]])
            self.constants[node.output[0]] = _onnx().numpy_helper.to_array(values["value"])
            return
        if kind == "Shape" and inputs == [self.value] and self._places():
            self.constants[node.output[0]] = np.array([0, self._places()])  # 0: as many frames as came
            return
        if kind in FOLDED and all(name in self.constants for name in inputs):
            self._fold(node, inputs)
            return
        self._expect_the_chain(node, inputs)
        if kind in ("Gemm", "MatMul"):
            self._multiply(node, values)
        elif kind in ("Add", "Sub", "Mul", "Div"):
            self._combine(node)
        elif kind in ("Sigmoid", "Tanh", "Relu", "LeakyRelu"):
            self._activate(kind, values)
        elif kind == "BatchNormalization":
            self._normalize(node, values)
        elif kind == "Reshape":
            self._reshape(self._constant(inputs[1], "iu").ravel())
        elif kind == "Flatten" and values.get("axis", 1) not in (1, -1):
            raise _Refused("a Flatten along another axis")
        elif kind == "Cast" and values["to"] not in (1, 11):
            raise _Refused("a Cast to " + _onnx().TensorProto.DataType.Name(values["to"]).lower(), "must have float or double")
        elif kind == "Dropout" and len(inputs) > 2 and self.constants.get(inputs[2], True):
            raise _Refused("a Dropout that learns", "must be exported for evaluation: model.eval()")
        elif kind not in ("Cast", "Dropout", "Flatten", "Identity", "Squeeze"):
            raise _Refused(f"the operation {kind}")
        self.before, self.value = (self.value, kind), node.output[0]

    def _expect_the_chain(self, node, inputs):
        if self.before and node.op_type == "Mul" and sorted(inputs) == sorted([self.before[0], self.value]) and self.before[1] == "Sigmoid":
            raise _Refused("the activation SiLU (x sigmoid(x), also called Swish)", "must have Sigmoid, Tanh, Relu or LeakyRelu")
        unknown = [name for name in inputs if name != self.value and name not in self.constants]
        if self.value not in inputs or unknown or inputs.count(self.value) > 1:
            raise _Refused(f"a graph with branches at its {node.op_type}")

    def _fold(self, node, inputs):
        made = _onnx().reference.ReferenceEvaluator(node).run(None, {name: self.constants[name] for name in inputs})
        self.spent += made[0].size
        if self.spent > MOST_NUMBERS:
            raise _Refused(f"products with more than {MOST_NUMBERS} numbers", "must have fewer")
        self.constants[node.output[0]] = made[0]

    def _constant(self, name, kinds="f"):
        found = self.constants.get(name)
        if found is None:
            raise _Refused("an operation on two values of the graph")
        if found.dtype.kind not in kinds or kinds == "f" and found.dtype.itemsize < 4:
            raise _Refused(f"numbers of type {found.dtype} in {name!r}", "must be float or double")
        return found.astype(np.float64) if kinds == "f" else found

    def _places(self):
        """Numbers of a frame here; 0: not known yet."""
        known = self.matrix is not None or self.layers or self.shift.size > 1
        return self.shift.size if known else 0

    def _know(self, places):
        """One number stands for all places until their count is known."""
        if not self._places() and places > 1:
            self.scale, self.shift = np.full(places, self.scale[0]), np.full(places, self.shift[0])
        if self.shift.size != places:
            raise _Refused(f"layers that do not fit each other: {self.shift.size} numbers into {places}")

    def _each(self, values):
        """A constant for each place, or one for all."""
        flat = values.ravel()
        if flat.size not in (1, values.shape[-1] if values.ndim else 1) or flat.size not in (1, self.shift.size):
            raise _Refused(f"a constant of shape {list(values.shape)} for {self.shift.size} places")
        return np.broadcast_to(flat, self.shift.shape)

    def _multiply(self, node, values):
        if node.input[0] != self.value or values.get("transA", 0):
            raise _Refused("a product with a transposed frame")
        weights = self._constant(node.input[1])
        if weights.ndim != 2:
            raise _Refused("a product with a list")
        self.spent += weights.size
        if self.spent > MOST_NUMBERS:
            raise _Refused(f"products with more than {MOST_NUMBERS} numbers", "must have fewer")
        weights = (weights if values.get("transB", 0) else weights.T) * values.get("alpha", 1.0)
        self._know(weights.shape[1])
        self.matrix = weights @ self.matrix if self.matrix is not None else weights * self.scale
        self.scale, self.shift = np.ones(len(weights)), weights @ self.shift
        if len(node.input) > 2 and node.input[2]:
            self.shift = self.shift + values.get("beta", 1.0) * self._each(self._constant(node.input[2]))

    def _rescale(self, by):
        if self.matrix is not None:
            self.matrix = by[:, None] * self.matrix
        else:
            self.scale = self.scale * by
        self.shift = self.shift * by

    def _combine(self, node):
        first = node.input[0] == self.value
        other = self._constant(node.input[1 if first else 0])
        self._know(max(other.shape[-1] if other.ndim else 1, self.shift.size))
        numbers = self._each(other)
        if node.op_type == "Div" and not first:
            raise _Refused("a constant over a value")
        if node.op_type in ("Mul", "Div"):
            self._rescale(numbers if node.op_type == "Mul" else 1 / numbers)
            return
        if node.op_type == "Sub" and not first:
            self._rescale(-np.ones_like(numbers))
        self.shift = self.shift + (-numbers if node.op_type == "Sub" and first else numbers)

    def _normalize(self, node, values):
        """(x - mean) / sqrt(variance + epsilon) * scale + bias, as when it does not learn."""
        if values.get("training_mode", 0):
            raise _Refused("a BatchNormalization that learns", "must be exported for evaluation: model.eval()")
        constants = [self._constant(name) for name in node.input[1:]]
        self._know(constants[0].size)
        gain, bias, mean, variance = map(self._each, constants)
        scale = gain / np.sqrt(variance + values.get("epsilon", np.float32(1e-5)))
        self._rescale(scale)
        self.shift = self.shift + bias - mean * scale

    def _reshape(self, extents):
        """To [frames, places]; of one place to [frames], too."""
        places = self._places()
        frames = (0, -1, 1, self.batch or -1)
        if extents.size == 1 and places == 1 and extents[0] == -1:
            return
        if extents.size == 2 and extents[0] in frames and (extents != -1).any():
            if extents[1] in (-1, 0) or extents[1] == places == 1:
                return
            if extents[1] > 1:
                self._know(int(extents[1]))
                return
        raise _Refused("a Reshape of a frame")

    def _activate(self, kind, values):
        if self.matrix is None:
            raise _Refused(f"{kind} without a dense layer before it")
        slope = values.get("alpha", 0.01) if kind == "LeakyRelu" else 0.0
        name = {"Sigmoid": "sigmoid", "Tanh": "tanh"}.get(kind, "leaky-relu")
        self.layers.append((self.matrix, self.shift, name, float(slope)))
        self.matrix, self.scale, self.shift = None, np.ones(len(self.shift)), np.zeros(len(self.shift))


_SIGMOID = "must end in one output through a sigmoid: the answer lies between 0 and 1; learn with torch.nn.Sigmoid() at the end"


def network(path, **options):
    """Returns the Network of an ONNX file's dense layers. options: those of Network.from_arrays but activation and slope. Raises
    InputError with the operation that is none of a chain's."""
    try:
        layers = _Chain(_load(path)).layers
    except _Refused as refused:
        raise input_error(f"{os.fspath(path)}: network", refused.problem, refused.fix) from None
    weights, biases, kinds, slopes = zip(*layers)
    try:
        return Network.from_arrays(weights, biases, list(kinds[:-1]), slope=list(slopes[:-1]),
                                   **{"name": os.path.basename(os.fspath(path)), **options})
    except InputError as error:
        raise input_error(f"{os.fspath(path)}: {error.place}", error.problem, error.fix) from None


def _difference(path, inputs):
    """Largest |answer of the network - answer of the graph| on random scaled frames, each evaluated by its own program; NaN where either
    is no number."""
    model = _load(path)
    value, = [one for one in model.graph.input if one.name not in {tensor.name for tensor in model.graph.initializer}]
    kind = value.type.tensor_type
    frames = np.random.default_rng(1).uniform(-2, 2, (RANDOM_FRAMES, inputs)).astype(np.float32)
    batch = kind.shape.dim[0].dim_value if kind.shape.dim else 0
    parts = np.split(frames[:len(frames) // batch * batch], len(frames) // batch) if batch else [frames]
    graph = _onnx().reference.ReferenceEvaluator(model)
    made = network(path, axes=1)  # the scaling is judged by --frames alone
    with np.errstate(all="ignore"):
        return max(np.abs(np.ravel(graph.run(None, {value.name: part.astype(float if kind.elem_type == 11 else np.float32)})[0])
                          - made(part)).max() for part in parts)


def _read_frames(path, inputs):
    rows = []
    try:
        with open(path, encoding="utf-8-sig") as file:
            for number, line in enumerate(file, 1):
                words = line.strip().split(",")
                if words == [""]:
                    continue
                if len(words) != inputs + 1:
                    raise input_error(f"{path}:{number}: fields", str(len(words)),
                                      f"must be {inputs + 1}: an input in MPa, then S of the other program")
                rows.append([_number(path, number, column, word) for column, word in enumerate(words, 1)])
    except (OSError, UnicodeDecodeError) as error:
        raise input_error(path, f"cannot be read ({error})", "must be a readable CSV file") from None
    if not rows:
        raise input_error(f"{path}: frames", "none", "at least one line of an input and its S")
    return np.array(rows)


def _number(path, line, column, word):
    try:
        value = float(word)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise input_error(f"{path}:{line}: column {column}", repr(word), "must be a finite number")
    return value


def _arguments(words):
    parser = argparse.ArgumentParser(prog="python -m tactel.import_network", description="Take a network that another program trained.",
                                     epilog="Exit codes: 0 done, 2 wrong input, 4 other answers than the network's own.")
    add = parser.add_argument
    add("network", metavar="OWN.onnx", help="a chain of dense layers, such as PyTorch exports")
    add("--output", required=True, metavar="N.onnx", help="network file to write")
    add("--profile", metavar="P.toml", help="sensor that it is for: checks the number of inputs; needed of a pad")
    add("--frames", metavar="FILE.csv", help="inputs (MPa) and S of the other program, line by line, to check by")
    add("--scaling", choices=("set", "frame", "rest"), default="set", help="what divides a frame before the network: --largest-stress "
        "(set), its largest normal stress (frame), or, of its difference to the rest of a grip, the force at rest (rest)")
    add("--largest-stress", type=float, default=1.0, help="divisor of --scaling set, MPa (default: 1)")
    add("--history", default="", metavar="K[:STRIDE]", help="frames in an input, newest first, as of tactel train")
    add("--history-change", type=float, help="as of tactel train (default: 0.1)")
    add("--target", choices=("slip_index", "force_ratio", "stick_fraction", "slid", "slip_path", "net_slip", "slid_ahead"), default="slip_index",
        help="what it answers, as of tactel train")
    return parser.parse_args(words)


def _run(given):
    axes = 2
    if given.profile:
        with open_sensor("csv:" + os.devnull, given.profile) as sensor:
            axes, places = sensor.inputs // sensor.tactels, sensor.inputs
    made = network(given.network, scaling=given.scaling, largest_stress=given.largest_stress, axes=axes, history=given.history,
                   history_change=given.history_change, target=given.target)
    own = int(made.topology.split("-")[0])
    shown = int((given.history or "1").split(":")[0])
    if given.profile and own != places * shown:
        raise input_error(f"{given.network}: network", f"{own} inputs",
                          f"a network of {places * shown} inputs for {given.profile}: normal stresses of all tactels, then the others")
    most, where = _difference(given.network, own), f"{RANDOM_FRAMES} random frames"
    if given.frames and most <= LARGEST_DIFFERENCE:
        lines = _read_frames(given.frames, own + (own // shown if given.scaling == "rest" else 0))
        most = np.abs(made(lines[:, :-1].astype(np.float32)) - lines[:, -1]).max()
        where = f"the {len(lines)} frames of {given.frames}"
    if np.isnan(most):
        print(f"tactel.import_network: {given.network}: an S on {where} is no number, by overflow; {given.output} was not written", file=sys.stderr)
        return 4
    if most > LARGEST_DIFFERENCE:
        print(f"tactel.import_network: {given.network}: S differs by {most:.2g} on {where}; {given.output} was not written; "
              "give the scaling that the network learnt with (--scaling, --largest-stress)", file=sys.stderr)
        return 4
    made.to_onnx(given.output)
    print(f"{given.output}: {made.topology}, within {most:.1g} of {given.network} on {where}")
    return 0


def main(words=None):
    return exit_code("import_network", _run, _arguments(words))


if __name__ == "__main__":
    sys.exit(main())
