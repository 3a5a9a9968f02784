# SPDX-License-Identifier: Apache-2.0
"""tactel: simulates a tactile skin and detects incipient slip.

Lengths are in mm, stresses in MPa, forces in N per mm of depth, angles in degrees. x runs along the array, y up from the
base. sigma_y < 0 is compression; tau_xy > 0 where the rubber is dragged toward +x. S = Q / (mu P).
On a Pad x and y lie in its plane, z points up from the base, and forces are in N. Forces are those of the object on the rubber.

    scene = tactel.Scene(tactel.Sensor(), tactel.Parabola(radius=10), friction=0.5, load=tactel.Press(0.15).drag(0.05, steps=8))
    path = tactel.solve(scene)
    path.slip_index, path.tactels.normal
"""

from __future__ import annotations

import functools as _functools
import html as _html
import os as _os
import sys as _sys
import time as _time
import typing as _typing

from . import _interpreter as _interpreter, _driver as _driver, _calls, _tactel
from ._tactel import *  # noqa: F403
from ._tactel import __version__

__all__ = sorted({name for name in vars(_tactel) if not name.startswith("_")} | {"solve_many", "train"})

if _typing.TYPE_CHECKING:  # names of types, for the functions below and the module; the build makes __init__.pyi of all
    import os
    from collections.abc import Callable, Iterable, Iterator, Sequence
    from typing import Any, Literal, TypeVar, overload

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Pair = tuple[float, float] | list[float]
    Float32 = NDArray[np.float32]
    Float64 = NDArray[np.float64]
    Shown = bool | Callable[[int, int], Any] | None
    Precision = Literal["", "fp32", "fp64"]
    _Value = TypeVar("_Value")

    class _LineScene(Scene):
        @property
        def sensor(self) -> Sensor: ...
        @property
        def indenter(self) -> Indenter: ...
        @property
        def load(self) -> Load: ...

    class _PadScene(Scene):
        @property
        def sensor(self) -> Pad: ...
        @property
        def indenter(self) -> PadIndenter: ...
        @property
        def load(self) -> PadLoad: ...


def _values(self):
    return tuple(getattr(self, name) for name in self._fields)


def _with(self: _Value, **changes: Any) -> _Value:
    """Returns a copy with these fields changed."""
    for name in changes:
        if name not in self._fields:
            raise _calls.unknown(f"{type(self).__name__}.with_", name, self._fields)
    return type(self)(**{name: changes.get(name, getattr(self, name)) for name in self._fields})


def _describe(self):
    return f"{type(self).__name__}({', '.join(f'{name}={getattr(self, name)!r}' for name in self._fields)})"


def _equal(a, b):
    return a.tolist() == b.tolist() if hasattr(a, "tolist") else a == b


for _class in vars(_tactel).values():
    if "_fields" not in getattr(_class, "__dict__", {}):
        continue
    _class.with_ = _with
    _class.__repr__ = _describe
    _class.__eq__ = lambda self, other: type(self) is type(other) and all(map(_equal, _values(self), _values(other)))
    _class.__hash__ = None
    _class.__reduce__ = lambda self: (type(self), _values(self))


def _keeping(kind, name, *replaced):
    """Has an object keep the arguments of the last call of a method, which a copy of it makes again, in place of those of others."""
    method = getattr(kind, name)

    @_functools.wraps(method)
    def call(self, *args, **kwargs):
        answer = method(self, *args, **kwargs)
        calls = self.__dict__.setdefault("_calls", {})
        for old in (name, *replaced):
            calls.pop(old, None)
        calls[name] = [_own(one) for one in args], {word: _own(one) for word, one in kwargs.items()}
        return answer

    setattr(kind, name, call)


def _own(value):
    """A copy of an array or a list: its owner may change it."""
    return value.copy() if hasattr(value, "copy") else value


def _made_again(kind, calls, state=None):
    made = kind.__new__(kind)
    for name, (args, kwargs) in calls.items():
        getattr(made, name)(*args, **kwargs)
    if state is not None:
        made.set_state(state)
    return made


_keeping(Alarm, "__init__")
Alarm.__reduce__ = lambda self: (_made_again, (type(self), self._calls))
for _call in ("__init__", "set_friction", "set_dt", "places"):
    _keeping(PadStepper, _call)
_keeping(PadStepper, "shapes", "places", "_gaps")
_keeping(PadStepper, "_gaps", "shapes", "places")
PadStepper.__reduce__ = lambda self: (_made_again, (type(self), self._calls, self.state()))


def _repr_html(self) -> str:
    """The page of the answer, in a notebook."""
    return f'<iframe srcdoc="{_html.escape(self.html())}" style="width: 100%; height: 50em; border: 0"></iframe>'


for _class in (Path, PadPath):
    _class._repr_html_ = _repr_html


def _with_prefix(number):
    for limit, prefix in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if number >= limit:
            return f"{number / limit:.3g}{prefix}"
    return f"{number:.3g}"


def _duration(seconds):
    whole = round(min(max(seconds, 0), 1e9))
    if whole < 60:
        return f"{whole} s"
    return f"{whole // 60} min {whole % 60:02} s" if whole < 3600 else f"{whole // 3600} h {whole // 60 % 60:02} min"


class _Progress:
    """The function (done, all) of a progress argument: None, a function, or True for a line on stderr, or below a notebook's cell, as the program prints it."""

    def __init__(self, progress, job, unit):
        self.job, self.unit, self.first, self.drawn = job, unit, None, None
        terminal = _sys.stderr is not None and _sys.stderr.isatty()
        notebook = type(_sys.stderr).__module__.startswith("ipykernel")  # which removes escapes
        self.clear = "\r\x1b[K" if terminal else "\r" + 79 * " " + "\r" if notebook else ""
        self.function = self.show if progress is True else None if progress is False else progress

    def show(self, done, total):
        now = _time.monotonic()
        self.first = self.first or (now, done)
        if _sys.stderr is None or now - (self.drawn or self.first[0]) < (1 if not self.drawn else 0.2 if self.clear else 30):
            return
        rate = (done - self.first[1]) / (now - self.first[0])
        pace = f", {_with_prefix(rate)} {self.unit}/s, {_duration((total - done) / rate)} left" if rate > 0 else ""
        self.drawn = now
        self.print(f"{self.job}: {100 * done / max(total, 1):.1f} %{pace}")

    def print(self, text):
        print(f"{self.clear}{text}" if self.clear else f"{text}\n", end="", file=_sys.stderr, flush=True)

    def __enter__(self):
        return self.function

    def __exit__(self, *raised):
        if self.drawn and self.clear:
            self.print("")


@_typing.overload
def solve_many(scenes: Iterable[_LineScene], *, accuracy: float | None = None, rung: str = "", precision: Precision = "",
               device: str = "", keep: None = None, progress: Shown = None) -> Paths: ...
@_typing.overload
def solve_many(scenes: Iterable[_PadScene], *, accuracy: float | None = None, rung: str = "", precision: Precision = "",
               device: str = "", keep: None = None, progress: Shown = None) -> PadPaths: ...
@_typing.overload
def solve_many(scenes: Iterable[Scene], *, accuracy: float | None = None, rung: str = "", precision: Precision = "",
               device: str = "", keep: None = None, progress: Shown = None) -> Any: ...
@_typing.overload
def solve_many(scenes: Iterable[Scene], *, accuracy: float | None = None, rung: str = "", precision: Precision = "",
               device: str = "", keep: str, progress: Shown = None) -> NDArray[Any]: ...
def solve_many(scenes, *, accuracy=None, rung="", precision="", device="", keep=None, progress=None):
    """Solves scenes in batches on the device: all on lines, or all on pads with the same tactels.

    keep: None returns Paths, of pads PadPaths; "tactels" the frames alone, [scenes, steps, 2 tactels] fp32, of pads [scenes,
    steps, axes tactels]; the name of another array that array. progress: True for a line on stderr, or a function (done, all). Raises InputError, which names the scene by its
    index, HardwareError.
    """
    words = locals()
    arrays = [name for name in dict.fromkeys(dir(Paths) + dir(PadPaths)) if not name.startswith("_")]
    if keep is not None and keep not in arrays:
        raise _calls.unknown("solve_many: keep", keep, arrays, "array")
    with _Progress(progress, "scenes", "scenes") as told:
        paths = _tactel._solve_many(list(scenes), words, told)
    return paths if keep is None else paths.frames if keep == "tactels" else getattr(paths, keep)


class Sweep(_tactel.Sweep):
    """The contacts of a sweep file (TOML): contact k is a function of the file, its seed and k alone."""

    path: str

    def __init__(self, path: str | os.PathLike[str], seed: int | None = None, *, tactels: int | None = None,
                 thickness: float | None = None) -> None:
        """seed, tactels and thickness (mm) take the place of the file's."""
        super().__init__(path, seed, tactels, thickness)
        self.path = _os.fspath(path)
        self._process = _os.getpid()
        self._seed, self._sensor = seed, {"tactels": tactels, "thickness": thickness}

    def __reduce__(self):
        return _sweep_again, (type(self), _os.path.abspath(self.path), self._seed, self._sensor, self._text, self._process)

    def generate(self, contacts: int | None = None, *, accuracy: float | None = None, rung: str = "", precision: Precision = "",
                 device: str = "", progress: Shown = None) -> Set:
        """Returns the rows of the first contacts (None: those of the file) as a Set, the same as those of `tactel generate`."""
        words = locals()
        with _Progress(progress, "contacts", "contacts") as told:
            return self._generate(contacts, words, told)

    @_typing.overload
    def batches(self, contacts: int = 8192, *, seed: int | None = None, first: int | None = None, sets: Literal[False] = False,
                accuracy: float | None = None, rung: str = "", precision: Precision = "",
                device: str = "") -> Iterator[tuple[Float32, Float32]]: ...
    @_typing.overload
    def batches(self, contacts: int = 8192, *, seed: int | None = None, first: int | None = None, sets: Literal[True],
                accuracy: float | None = None, rung: str = "", precision: Precision = "", device: str = "") -> Iterator[Set]: ...
    def batches(self, contacts=8192, *, seed=None, first=None, sets=False, accuracy=None, rung="", precision="", device=""):
        """Iterates over the rows of so many contacts a time, which are never stored: (frames, slip_index), or Sets.

        frames: [rows, 2 tactels] MPa, fp32; slip_index: [rows]. In one of several processes, as the workers of a DataLoader,
        seed or first must be given: all would draw the same contacts.
        """
        words = locals()
        if seed is None and first is None and self._shared():
            raise _calls.input_error("Sweep.batches", "this process is one of several, and each would draw the same contacts",
                                     "give each a seed or a first contact, or take one process: the device has threads")
        first = first or 0
        sweep = self if seed is None else Sweep(self.path, seed, **self._sensor)
        return sweep._batches(contacts, first, sets, words)

    def _shared(self):
        """Whether other processes may hold this sweep, too: it came by a fork, or a DataLoader of PyTorch has several workers."""
        data = _sys.modules.get("torch.utils.data")
        worker = data.get_worker_info() if data else None
        return worker.num_workers > 1 if worker else self._process != _os.getpid()


def _sweep_again(kind, path, seed, sensor, text, process):
    """Returns a sweep of the same file. In another process it is one of several."""
    sweep = kind(path, seed, **sensor)
    if sweep._text != text:
        raise _calls.input_error(path, "changed since the sweep was pickled", "pickle it again")
    sweep._process = process
    return sweep


def _widths(layers):
    """ "42-42-21-1" of a name, a tuple of widths, or a list of either."""
    if isinstance(layers, str):
        return [layers]
    if all(isinstance(width, int) for width in layers):
        return ["-".join(str(width) for width in layers)]
    return [name for one in layers for name in _widths(one)]


def train(data: Set, layers: str | Sequence[int] | Sequence[str | Sequence[int]] = (42, 42, 21, 1), *, seeds: int = 1,
          first_seed: int = 1, noise: float | Sequence[float] = 0.0, scaling: Literal["set", "frame", "rest"] = "set",
          features: Literal["frame", "line", "pad"] = "frame",
          schedule: Literal["batch", "cosine", "online"] = "batch", optimizer: Literal["", "adam", "delta"] = "",
          loss: Literal["", "absolute", "squared"] = "", cycles: int | None = None, batch: int | None = None,
          rate: float | None = None, warm_up: float | None = None, average: float | None = None, validation: Set | None = None,
          patience: int | None = None, bound: bool = False, level: float | None = None, history: int | str = "",
          history_change: float | None = None, target: Literal["slip_index", "force_ratio", "stick_fraction", "slid", "slip_path", "net_slip", "slid_ahead"] = "slip_index",
          friction: bool = False, inputs: Literal["stresses", "markers"] = "stresses", device: str = "", progress: Shown = None) -> list[Network]:
    """Trains networks on a Set: every topology, noise and seed. Returns a list of Network.

    layers: widths, a name such as "42-42-21-1", "42-96-96-1_leaky-relu" (of mini-batches) or "6" (of the paper), or a list
    of them. noise: standard deviation of added noise over the set's largest |stress|, or a list. scaling: "set", "frame" or
    "rest", differences to the grip at rest. features: of scaling "frame" and "rest"; "line" or "pad": one of all mirror images of a frame, and its sums, before the network.
    schedule: "batch"; "cosine", mini-batches at a rate that warms up and falls to 0; or "online", the paper's rule. loss:
    "squared" (default) or "absolute". average: decay of the exponential mean of the weights (0: none). validation: a Set that
    judges each cycle; the weights of the smallest mean error are kept, and `patience` cycles without a smaller one end a
    training. bound: with the heads of an upper bound of S at `level` (0.95); `tactel calibrate bound` calibrates it. history:
    the last k frames kept by change of load (history_change, 0.1) as one input, "k" or "k:stride", of a set with press_rows.
    target: the column to learn. friction: networks take mu as far as it is known, Alarm.friction. inputs: "markers", how each
    moves along x and y, set.markers[:, :, :2], in the place of stresses. A network that diverges has no entry.
    """
    words = locals() | {"network": _widths(layers), "noise": [noise] if isinstance(noise, (int, float)) else list(noise), "history": str(history)}
    with _Progress(progress, "training", "weight updates") as told:
        return _tactel._train(data, validation, device, words, told)


_calls.check(globals(), __all__)
