# SPDX-License-Identifier: Apache-2.0
import os
from collections.abc import Callable, Iterator
from typing import Any

from . import Set

class Contacts:
    def __init__(self, path: str | os.PathLike[str], contacts: int = ..., *, batches: int | None = ..., seed: int | None = ...,
                 rows: Callable[[Set], tuple[Any, ...]] | None = ..., shuffle: int | None = ..., **options: Any) -> None: ...
    def __iter__(self) -> Iterator[tuple[Any, ...]]: ...
