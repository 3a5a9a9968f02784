# SPDX-License-Identifier: Apache-2.0
import os
from collections.abc import Sequence
from typing import Any

from . import Network

LARGEST_DIFFERENCE: float
RANDOM_FRAMES: int
MOST_BYTES: int
MOST_NUMBERS: int
MOST_OPERATIONS: int
A_CHAIN: str
FOLDED: set[str]

def network(path: str | os.PathLike[str], **options: Any) -> Network: ...
def main(words: Sequence[str] | None = ...) -> int: ...
