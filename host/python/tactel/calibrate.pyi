# SPDX-License-Identifier: Apache-2.0
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import Scene

OUTLIER: int
TRUST: int
MODEL_ERROR_LEFT: float
ERROR_GROUPS: int
MISFIT_FROM: int
UNJUDGED: float
DEGENERATE: float
NOT_TOLD: float
SWAPPED_SHARE: float
DEAD_SIGNAL: int
WRONG_PRESS: int
WRONG_INDENTER: int
MODEL_ERROR: float
MISFIT: float
UNSURE_OFFSET: float
PATIENCE: int
MOST_TURNS: int
LABELS: dict[str, tuple[str, str]]

@dataclass(frozen=True)
class Press:
    name: str
    scene: Scene
    readings: ArrayLike
    P: ArrayLike | None = ...
    timing: tuple[ArrayLike, ArrayLike, ArrayLike] | None = ...

@dataclass(frozen=True)
class Options:
    poisson: bool = ...
    thickness: bool = ...
    shift: bool = ...
    fit_time_constant: bool = ...
    time_constant: float = ...
    friction: float = ...
    force_noise: float = ...
    lowest_reading: float = ...
    highest_reading: float = ...
    rest_noise: ArrayLike | None = ...
    rungs: Sequence[str] = ...

@dataclass(frozen=True)
class Fault:
    kind: str
    text: str

@dataclass(frozen=True)
class Fitted:
    value: float
    deviation: float = ...
    def within(self, true: float, deviations: float = ...) -> bool: ...

@dataclass
class Calibration:
    converged: bool
    iterations: int
    numbers: dict[str, Fitted]
    friction: list[Fitted]
    gain: list[Fitted]
    offset: list[Fitted]
    noise: NDArray[np.float64]
    fitted: list[str]
    correlation: NDArray[np.float64]
    held: list[str]
    faults: list[Fault]
    residuals: list[NDArray[np.float64]]
    names: list[str]

def fit(presses: Sequence[Press], options: Options = ...) -> Calibration: ...
def to_json(found: Calibration, presses: Sequence[Press], noise: ArrayLike) -> dict[str, Any]: ...
def remarks_of(found: Calibration, presses: Sequence[Press], noise: ArrayLike) -> list[str]: ...
def page(found: Calibration, presses: Sequence[Press], remarks: Sequence[str]) -> str: ...
def amplifier_response(timing: tuple[ArrayLike, ArrayLike, ArrayLike], time_constant: float) -> NDArray[np.float64]: ...
def main(words: Sequence[str] | None = ...) -> int: ...
