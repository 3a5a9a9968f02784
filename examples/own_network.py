#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Trains a network in PyTorch on contacts that tactel simulates, and writes it as own.onnx.

  python examples/own_network.py
  python -m tactel.import_network own.onnx --scaling frame --frames own.csv --output slip.onnx
  tactel monitor --source 'simulate:examples/parabola.toml' --network slip.onnx
"""
import numpy as np
import tactel
import torch

network = torch.nn.Sequential(torch.nn.Linear(42, 64), torch.nn.ReLU(), torch.nn.Linear(64, 32), torch.nn.ReLU(),
                              torch.nn.Linear(32, 1), torch.nn.Sigmoid())
optimizer = torch.optim.Adam(network.parameters(), 1e-3)


def scaled(frames):
    """Each frame by its largest normal stress, as --scaling frame does it."""
    return torch.from_numpy(frames / np.abs(frames[:, :21]).max(axis=1, keepdims=True))


batches = tactel.Sweep("examples/random_sweep.toml").batches(contacts=500)  # without an end
for _, (frames, slip_index) in zip(range(30), batches):
    s = torch.from_numpy(slip_index)[:, None]
    for rows in torch.randperm(len(frames)).split(64):
        loss = (network(scaled(frames[rows])) - s[rows]).square().mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
print(f"root mean square error of S on the last contacts: {loss.sqrt():.3f}")

torch.onnx.export(network.eval(), (torch.zeros(1, 42),), "own.onnx")
with torch.no_grad():
    answers = network(scaled(frames[:100])).numpy()
np.savetxt("own.csv", np.hstack([frames[:100], answers]), delimiter=",")
