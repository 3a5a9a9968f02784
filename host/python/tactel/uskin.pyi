# SPDX-License-Identifier: Apache-2.0
import enum
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

class Label(enum.IntEnum):
    STILL = 0
    STILL_SLIP = 1
    RELEASED = 2
    GRASPED = 3
    MOVING = 4
    MOVING_SLIP = 5
    OTHER = 6

@dataclass(frozen=True)
class Trial:
    name: str
    time: NDArray[np.float64]
    label: NDArray[np.int64]
    frames: NDArray[np.float32]
    P: NDArray[np.float64]
    Q: NDArray[np.float64]
    friction: float
    slip_index: NDArray[np.float64]
    @property
    def slipping(self) -> NDArray[np.bool_]: ...

def trials(path: str | os.PathLike[str], *, shear: Literal["x", "y"] = "x", row: int = 1) -> Iterator[Trial]: ...
