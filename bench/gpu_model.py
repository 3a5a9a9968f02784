#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Traffic and occupancy of the contact kernels on a GPU: a model from their arrays, no measurement. Prints the tables of kernels/README.md.

Counted in fp32, by warp of 32 work-items and sectors of 32 bytes. The machine is an H100 by its data sheet. Numbers of arrays are those of
kernels/shared/contact_layout.h and patch_layout.h; sizes of private structs are clang's, by -fdump-record-layouts at 12 elements."""

WARP, SECTOR, NUMBER = 32, 32, 4
SMS, CLOCK, L1, MEMORY = 132, 1.7e9, 256e3, 3.35e12  # multiprocessors, 1/s, bytes of each, bytes/s
REGISTERS, ISSUED = 65536, 4  # of a multiprocessor; warp instructions a cycle
PEAK = SMS * CLOCK * 256  # FLOP/s: 128 fused operations a cycle
# Gauss-Seidel sweeps: of a lane alone, and of the slowest of 32 in the order of lanes. From a processor: `sweeps`, `sweeps_of_warp`,
# `path_sweeps` and `path_sweeps_of_warp` of tactel_bench; the numbers of sweeps do not depend on the device.
SWEEPS = {"mesh B, a load step": (5.46, 6.17), "mesh A, a load step": (10.8, 13.8), "12 elements, a path": (59.1, 84.9)}


def sectors(numbers, neighbours_beside):
    """Sectors of a warp whose items each access so many numbers of their own arrays."""
    return numbers * (WARP * NUMBER // SECTOR if neighbours_beside else WARP)


def traffic():
    # Numbers a scene: inputs once, profile a step (first gap elements, certificate, nodes outside), answers a step.
    tactels, steps = 42, 8
    mesh = {"inputs": (5 + 2 * steps) / steps, "profile": 3 * 41, "answers": 15 + 2 + tactels}
    patch = {"inputs": (29 + 3 * (steps + 3)) / steps, "answers": 16 + 32 + 48}
    print("| a load step of a warp, sectors | scene by scene | 64 scenes side by side |\n|---|---|---|")
    for name, parts in (("mesh B", mesh), ("12 elements", patch)):
        numbers = sum(parts.values())
        print(f"| {name}: {numbers:.0f} numbers a scene | {sectors(numbers, False):.0f} | {sectors(numbers, True):.0f} |")


def occupancy():
    n = 12
    # kernels/patch_contact.cl: c without the factors of an element on itself, n, t, b and bt of Contact in each sweep; all of Contact,
    # Reports and inputs.
    hot = (4 * n * n - 2 * n + 4 * n) * NUMBER
    kept = (4 * n * n + 28 * n + 6) * NUMBER + (10 * (2 * n + 14) + 5) * NUMBER + 29 * NUMBER
    scenes = L1 / kept
    from_memory = MEMORY / hot
    flop = 8 * n * n
    print("\n| 12 elements | one scene an item | one scene 16 items |\n|---|---|---|")
    # A lane keeps its two rows of C (4 n numbers) and some 30 others; an element's update takes 4 fused operations, 2 shuffles, 14 others.
    registers, instructions = 4 * n + 32, 20
    warps = REGISTERS // (registers * WARP)
    sweeps = SMS * CLOCK * ISSUED / (n * instructions) * 2
    print(f"| private memory a scene | {kept} bytes, {hot} of them in each sweep | registers, {registers} a lane |")
    print(f"| scenes a multiprocessor holds | {scenes:.0f} in its first-level cache | {2 * warps} |")
    print(f"| bound | memory: {from_memory / 1e9:.1f} billion sweeps/s, {100 * from_memory * flop / PEAK:.0f} % of peak "
          f"| instructions: {sweeps / 1e9:.1f} billion sweeps/s, {100 * sweeps * flop / PEAK:.0f} % of peak |")


def divergence():
    print("\n| sweeps | alone | of a warp | lanes at work |\n|---|---|---|---|")
    for name, (alone, warp) in SWEEPS.items():
        print(f"| {name} | {alone} | {warp} | {100 * alone / warp:.0f} % |")


if __name__ == "__main__":
    traffic()
    occupancy()
    divergence()
