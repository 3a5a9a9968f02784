# SPDX-License-Identifier: Apache-2.0
"""Contacts of a sweep for PyTorch, drawn as they are needed. Needs the package torch of PyPI.

    loader = torch.utils.data.DataLoader(tactel.torch.Contacts("sweep.toml"), batch_size=None, num_workers=2)
    for frames, slip_index in loader: ...
"""

import os

from torch import from_numpy
from torch.utils.data import IterableDataset, get_worker_info

from . import Sweep


class Contacts(IterableDataset):
    """Batches of a sweep file: the rows of `contacts` contacts each, as `rows(set)` returns them, in tensors.

    rows: None for set.frames and set.slip_index; lambda set: set.inputs(history=4) for others. batches: in all, None without end.
    Worker k of n takes every n-th batch from k on: each has contacts of its own, and all together are those of one process.
    Other arguments are those of Sweep.batches."""

    def __init__(self, path, contacts=4096, *, batches=None, seed=None, rows=None, **options):
        super().__init__()
        self.path, self.contacts, self.count, self.seed, self.rows, self.options = os.fspath(path), contacts, batches, seed, rows, options

    def __iter__(self):
        worker = get_worker_info()
        number, step = (worker.id, worker.num_workers) if worker else (0, 1)
        sweep = Sweep(self.path, self.seed)
        while self.count is None or number < self.count:
            found = next(iter(sweep.batches(self.contacts, first=number * self.contacts, sets=True, **self.options)))
            arrays = self.rows(found) if self.rows else (found.frames, found.slip_index)
            yield tuple(from_numpy(array.copy()) for array in arrays)
            number += step
