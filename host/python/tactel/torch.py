# SPDX-License-Identifier: Apache-2.0
"""Contacts of a sweep for PyTorch, drawn as they are needed. Needs the package torch of PyPI.

    loader = torch.utils.data.DataLoader(tactel.torch.Contacts("sweep.toml", shuffle=256), batch_size=None, num_workers=2)
    for frames, slip_index in loader: ...
"""

import os

import numpy as np
from torch import from_numpy
from torch.utils.data import IterableDataset, get_worker_info

from . import Sweep
from ._calls import input_error


class Contacts(IterableDataset):
    """Batches of a sweep file: the rows of `contacts` contacts each, as `rows(set)` returns them, in tensors.

    rows: None for set.frames and set.slip_index; lambda set: set.inputs(history=4) for others. batches: in all, None without end.
    shuffle: a batch becomes mini-batches of so many of its rows, in random order by the seed; None keeps it, contact after contact.
    Worker k of n takes every n-th batch from k on: each has contacts of its own, and all together are those of one process.
    Other arguments are those of Sweep.batches. Throws InputError for a shuffle below 1."""

    def __init__(self, path, contacts=4096, *, batches=None, seed=None, rows=None, shuffle=None, **options):
        super().__init__()
        if shuffle is not None and shuffle < 1:
            raise input_error("shuffle", shuffle, "rows of a mini-batch, 1 or more, or None")
        self.path, self.contacts, self.count, self.seed, self.rows, self.options = os.fspath(path), contacts, batches, seed, rows, options
        self.shuffle = shuffle

    def __iter__(self):
        worker = get_worker_info()
        number, step = (worker.id, worker.num_workers) if worker else (0, 1)
        sweep = Sweep(self.path, self.seed)
        while self.count is None or number < self.count:
            found = next(iter(sweep.batches(self.contacts, first=number * self.contacts, sets=True, **self.options)))
            arrays = self.rows(found) if self.rows else (found.frames, found.slip_index)
            count = len(arrays[0])
            order = np.random.default_rng((self.seed or 0, number)).permutation(count) if self.shuffle else np.arange(count)
            for some in np.split(order, range(self.shuffle, count, self.shuffle) if self.shuffle else []):
                yield tuple(from_numpy(array[some]) for array in arrays)
            number += step
