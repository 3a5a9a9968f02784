# SPDX-License-Identifier: Apache-2.0
"""Evaluates the graph of an ONNX file with NumPy, in single precision: a witness that shares nothing with the package."""
import numpy as np


def fields(data):
    """Yields (number, value) of a protobuf message: integers, 4 or 8 bytes, or the bytes of what has a length."""
    at = 0

    def varint():
        nonlocal at
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    while at < len(data):
        key = varint()
        if key & 7 == 0:
            value = varint()
        else:
            size = {1: 8, 5: 4}.get(key & 7) or varint()
            value = bytes(data[at:at + size])
            at += size
        yield key >> 3, value


def every(message, number):
    return [value for key, value in fields(message) if key == number]


def tensor(message):
    """(name, array) of a TensorProto with raw data."""
    (name,), (data,) = every(message, 8), every(message, 9)
    kind = {1: np.float32, 7: np.int64}[every(message, 2)[0]]
    return name.decode(), np.frombuffer(data, kind).reshape(every(message, 1))


def attributes(node):
    """Integers and floats of a NodeProto by name."""
    found = {}
    for attribute in every(node, 5):
        if floats := every(attribute, 2):
            found[every(attribute, 1)[0].decode()] = np.frombuffer(floats[0], np.float32)[0]
            continue
        numbers = every(attribute, 3) or every(attribute, 8)
        found[every(attribute, 1)[0].decode()] = int.from_bytes(numbers[0], "little") if isinstance(numbers[0], bytes) else numbers[0]
    return found


OPERATORS = {
    "Abs": lambda a, **_: np.abs(a),
    "Add": lambda a, b, **_: a + b,
    "Cast": lambda a, to, **_: a.astype({1: np.float32, 7: np.int64}[to]),
    "Concat": lambda *all, axis, **_: np.concatenate(all, axis),
    "Div": lambda a, b, **_: a / b,
    "Gather": lambda a, b, **_: a[b],
    "GatherElements": lambda a, b, axis, **_: np.take_along_axis(a, b, axis),
    "Gemm": lambda a, b, c, transB=0, **_: a @ (b.T if transB else b) + c,
    "Greater": lambda a, b, **_: a > b,
    "LeakyRelu": lambda a, alpha=np.float32(0.01), **_: np.where(a > 0, a, alpha * a),
    "Less": lambda a, b, **_: a < b,
    "LessOrEqual": lambda a, b, **_: a <= b,
    "MatMul": lambda a, b, **_: a @ b,
    "Max": lambda a, b, **_: np.maximum(a, b),
    "Min": lambda a, b, **_: np.minimum(a, b),
    "Mul": lambda a, b, **_: a * b,
    "Neg": lambda a, **_: -a,
    "Not": lambda a, **_: ~a,
    "ReduceMax": lambda a, **_: a.max(axis=1, keepdims=True),
    "ReduceSum": lambda a, axes, **_: a.sum(axis=tuple(axes), keepdims=True),
    "Reshape": lambda a, shape, **_: a.reshape(shape),
    "Slice": lambda a, first, end, axes, **_: a[:, first[0]:end[0]],
    "Sqrt": lambda a, **_: np.sqrt(a),
    "Squeeze": lambda a, axes, **_: a.squeeze(tuple(axes)),
    "Sub": lambda a, b, **_: a - b,
    "Tanh": lambda a, **_: np.tanh(a),
    "Where": lambda a, b, c, **_: np.where(a, b, c),
}


def evaluate(path, frames):
    """Every value of the graph by name, for frames [batch, inputs]."""
    with open(path, "rb") as file:
        (graph,) = every(file.read(), 7)
    values = dict(tensor(message) for message in every(graph, 5))
    values["frame"] = np.asarray(frames, np.float32)
    for node in every(graph, 1):
        (operator,), (output,) = every(node, 4), every(node, 2)
        inputs = [values[name.decode()] for name in every(node, 1)]
        values[output.decode()] = OPERATORS[operator.decode()](*inputs, **attributes(node))
    return values
