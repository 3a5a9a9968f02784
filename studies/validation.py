#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares tactel with closed forms, and its patch with its mesh: prints tables such as those of
docs/notebook/2026-11-23-validation.md and docs/pads-validation.md and draws their figures, docs/validation_*.svg.

Usage: PYTHONPATH=build/python studies/validation.py [--build build] [NAME...]  (the sections to run, all by default)
Pads are solved by the program.
Lengths are in mm, stresses in MPa, forces in N/mm. Debian: python3-numpy, python3-matplotlib."""
import json
import pathlib
import tempfile

import numpy as np

import study
import tactel
from study import BLUE, EXACT, GREEN, ORANGE

PATCHES = ("patch-8", "patch-12", "patch-16", "patch-24", "reference")
ELEMENTS = {"patch-8": 8, "patch-12": 12, "patch-16": 16, "patch-24": 24, "reference": 120}

E, NU, R, MU = 2.0, 0.5, 10.0, 0.5  # of the half-plane; at nu = 1/2 pressure and shear are not coupled
H = 1000.0
HALF_PLANE = tactel.Sensor(length=40 * H, thickness=H, young=E, poisson=NU)
STIFFNESS = E / (1 - NU**2)
SOFTNESS = 2 / (np.pi * STIFFNESS)  # displacement under a line force, to the factor ln(1/|x|)


def figure(name, panels=2):
    shown, axes = study.panels(1, panels, figsize=(4.2 * panels, 3.3))

    def save():
        path = study.DOCS / f"validation_{name}.svg"
        study.save(shown, path)
        print(f"  {path.name}: {path.stat().st_size / 1000:.0f} kB\n")

    return axes, save


def elements(path):
    """Middles and boundaries of a patch's elements: equal ones, or those of a centred patch, which meet at 0."""
    x = path.surface_x
    width = np.diff(x)
    if np.ptp(width) < 1e-9 * width[0]:
        return x, np.append(x - width[0] / 2, x[-1] + width[0] / 2)
    half = [0.0]
    for middle in x[len(x) // 2:]:
        half.append(2 * middle - half[-1])
    return x, np.array([-b for b in half[:0:-1]] + half)


def tractions(path, step):
    """Pressure and shear of the elements."""
    width = np.diff(elements(path)[1])
    return path.normal_force[step] / width, path.tangential_force[step] / width


def mean_root(edges, r):
    """Means of sqrt(r^2 - x^2) over the elements between these boundaries."""
    x = np.clip(edges, -r, r)
    return np.diff(x * np.sqrt(r**2 - x**2) + r**2 * np.arcsin(x / r)) / 2 / np.diff(edges)


def order(sizes, errors):
    """Slope of the error over the number of elements, by least squares on logarithms."""
    return -np.polyfit(np.log(sizes), np.log(errors), 1)[0]


# The half-plane: closed forms ------------------------------------------------------------------------------------


def contact_half_width(P):
    return np.sqrt(4 * P * R / (np.pi * STIFFNESS))


def hertz_pressure(P):
    return np.sqrt(P * STIFFNESS / (np.pi * R))


def layer_constant(sign):
    """The layer's part of the displacement near a line force, -1 for u_y and 1 for u_x (docs/theory.md)."""
    w = np.geomspace(1e-6, 40, 200_001)  # wavenumber times thickness
    k = 3 - 4 * NU
    D = k * np.cosh(2 * w) + 2 * w**2 + 1 + 4 * (1 - NU) * (1 - 2 * NU)
    return np.trapz((k * np.sinh(2 * w) + sign * 2 * w) / D - 1 + np.exp(-w), np.log(w))


def displacement(F, r, sign):
    """Displacement in the middle of an elliptic traction of total F and half-width r on the layer, r << H."""
    return SOFTNESS * F * (np.log(2 * H / r) + 0.5 + layer_constant(sign))


def drag_at(stick, P):
    """Drag at which the stick half-width is `stick` times that of the contact: Cattaneo and Mindlin on the layer."""
    a = contact_half_width(P)
    inner = displacement(MU * P * stick**2, stick * a, 1) if stick > 0 else 0
    return displacement(MU * P, a, 1) - inner


# Sections ----------------------------------------------------------------------------------------------------------


def hertz():
    """Line contact: pressure, half-width and depth against Hertz."""
    print("Hertz: E = 2, nu = 0.5, R = 10, thickness 1000 (half-plane), force given")
    (left, right), save = figure("hertz")
    P = 0.1
    for rung, mark, colour in (("patch-24", "o", BLUE), ("reference", ".", ORANGE)):
        path = tactel.solve(tactel.Scene(HALF_PLANE, tactel.Parabola(R), MU, tactel.Force(P)), rung=rung)
        thin = slice(None, None, 3 if rung == "reference" else 1)
        left.plot(path.surface_x[thin], tractions(path, -1)[0][thin], mark, color=colour, label=rung)
    a, x = contact_half_width(P), np.linspace(-1, 1, 201)
    left.plot(a * x, hertz_pressure(P) * np.sqrt(1 - x**2), color=EXACT, lw=1, label="Hertz")
    left.set(xlabel="x (mm)", ylabel="pressure (MPa)", title=f"P = {P} N/mm")
    left.legend(loc="lower center")

    loads = np.array([0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1])
    print("  rung       largest errors over the loads: p0   a (second moment)   depth   pressure, rms over p0")
    pressures = np.geomspace(loads[0], loads[-1])
    right.loglog(pressures, contact_half_width(pressures), color=EXACT, lw=1, label="Hertz")
    right.loglog(pressures, hertz_pressure(pressures), color=EXACT, lw=1)
    right.loglog(pressures, displacement(pressures, contact_half_width(pressures), -1), color=EXACT, lw=1)
    worst = {}
    for rung in PATCHES:
        errors = []
        for P in loads:
            path = tactel.solve(tactel.Scene(HALF_PLANE, tactel.Parabola(R), MU, tactel.Force(P)), rung=rung)
            x, edges = elements(path)
            pressure = tractions(path, -1)[0]
            a, p0 = contact_half_width(P), hertz_pressure(P)
            exact = p0 / a * mean_root(edges, a)
            touching = pressure > 0
            force, width = path.normal_force[-1], np.diff(edges)
            half_width = 2 * np.sqrt(np.sum(force * (x**2 + width**2 / 12)) / np.sum(force))  # Hertz: P a^2 / 4
            largest = pressure.max() / exact.max()
            depth = path.indentation[-1] / displacement(P, a, -1)
            errors.append((largest - 1, half_width / a - 1, depth - 1,
                           np.sqrt(np.mean((pressure - exact)[touching | (exact > 0)] ** 2)) / p0))
            if rung == "patch-24":
                for value, mark, colour, label in ((half_width, "s", BLUE, "half-width (mm)"),
                                                   (pressure.max(), "o", ORANGE, "largest pressure (MPa)"),
                                                   (path.indentation[-1], "^", GREEN, "depth (mm)")):
                    right.loglog(P, value, mark, color=colour, label=label if P == loads[0] else None)
        worst[rung] = np.max(np.abs(errors), axis=0)
        print(f"  {rung:9} " + " ".join(f"{error:10.6f}" for error in worst[rung]))
    for rung in ("patch-12", "patch-24"):
        exactly = [tactel.solve(tactel.Scene(HALF_PLANE, tactel.Parabola(R), MU, tactel.Force(P)), rung=rung,
                                precision="fp64", tolerance=1e-9).indentation[-1]
                   / displacement(P, contact_half_width(P), -1) - 1 for P in loads]
        print(f"  depth on {rung} in fp64 to 1e-9: {np.max(np.abs(exactly)):.6f}")
    orders = [order(list(ELEMENTS.values()), [error[column] for error in worst.values()]) for column in (0, 1, 3)]
    print("  orders in the number of elements: p0 {:.2f}, a {:.2f}, pressure {:.2f}".format(*orders))
    right.set(xlabel="P (N/mm)", ylabel="mm, MPa", title="patch-24 over seven loads")
    right.legend(fontsize=8)
    save()


def cattaneo():
    """Partial slip: stick half-width, shear traction and Q over the drag."""
    print("Cattaneo and Mindlin: the same half-plane, P = 0.1, mu = 0.5")
    (left, right), save = figure("cattaneo")
    P = 0.1
    a, p0 = contact_half_width(P), hertz_pressure(P)
    sticks = np.sqrt(1 - np.arange(0.1, 0.95, 0.1))
    drags = [drag_at(stick, P) for stick in sticks]
    inner = np.linspace(0, 1)
    left.plot(1 - inner**2, inner, color=EXACT, lw=1, label="closed form")
    for rung, mark, colour in (("patch-24", "o", BLUE), ("reference", ".", ORANGE)):
        scene = tactel.Scene(HALF_PLANE, tactel.Parabola(R), MU, tactel.Force(P).drag_to(drags))
        path = tactel.solve(scene, rung=rung)
        x, edges = elements(path)
        found, middle, shear = [], [], []
        centre = slice(len(x) // 2 - 1, len(x) // 2 + 1)
        for step in range(1, len(path)):
            found.append(np.sum(np.diff(edges)[path.status[step] == 1]) / 2 / a)
            pressure, traction = tractions(path, step)
            middle.append(1 - np.sum(traction[centre]) / np.sum(MU * pressure[centre]))
            exact = (mean_root(edges, a) - mean_root(edges, a * np.sqrt(1 - path.slip_index[step]))) / a
            shear.append(np.sqrt(np.mean((traction / (MU * p0) - exact)[pressure > 0] ** 2)))
            if step == 5:
                thin = slice(None, None, 3 if rung == "reference" else 1)
                right.plot(x[thin], (traction / (MU * p0))[thin], mark, color=colour, label=rung)
        S = path.slip_index[1:]
        left.plot(S, found, mark, color=colour, label=f"{rung}, by status")
        element = np.diff(edges)[0] / a
        inner = np.sqrt(1 - S)
        print(f"  {rung:9}  element {element:.3f} a; c/a off by {np.max(np.abs(found - inner)):.4f} by status, "
              f"{np.max(np.abs(middle - inner)):.4f} by the shear in the middle; shear, rms over mu p0: "
              f"{np.max(shear):.4f}; S at nine drags: {np.max(np.abs(S - 1 + sticks**2)):.5f}")
        print("    c/a found:", " ".join(f"{v:.3f}" for v in found))
        print("    by middle:", " ".join(f"{v:.3f}" for v in middle))
        print("    c/a exact:", " ".join(f"{v:.3f}" for v in inner))
    x = np.linspace(-a, a, 401)
    c = a * sticks[4]
    right.plot(x, np.sqrt(1 - (x / a) ** 2) - np.sqrt(np.clip(c**2 - x**2, 0, None)) / a, color=EXACT, lw=1,
               label="closed form")
    left.set(xlabel="Q / (mu P)", ylabel="stick half-width c / a")
    right.set(xlabel="x (mm)", ylabel="shear traction / (mu p0)", title="Q = 0.5 mu P")
    left.legend()
    right.legend(fontsize=8, loc="lower center")
    save()


def punch():
    """Flat punch without friction: pressure."""
    print("Flat punch on the half-plane: half-width 1, P = 0.1, mu = 0")
    axes, save = figure("punch", 1)
    P, a = 0.1, 1.0
    shown = {"patch-12": ("o", BLUE), "reference": (".", ORANGE)}
    for rung in PATCHES:
        path = tactel.solve(tactel.Scene(HALF_PLANE, tactel.Flat(a), 0.0, tactel.Force(P)), rung=rung)
        x, edges = elements(path)
        pressure = tractions(path, -1)[0]
        share = np.clip(edges, -a, a) / a
        exact = P / np.pi * np.diff(np.arcsin(share)) / np.diff(edges)
        error = np.abs(pressure / exact - 1)
        depth = path.indentation[-1] / (SOFTNESS * P * (np.log(2 * H / a) + layer_constant(-1))) - 1
        print(f"  {rung:9}  middle {error[len(x) // 2]:.5f}, within a/2 {np.max(error[np.abs(x) < a / 2]):.5f}, "
              f"second element from the edge {error[1]:.4f}, edge element {error[0]:.4f}, depth {depth:.6f}")
        if rung in shown:
            mark, colour = shown[rung]
            axes.plot(x, pressure, mark, color=colour, label=rung)
    x = np.sin(np.linspace(-1.53, 1.53, 401)) * a
    axes.plot(x, P / (np.pi * np.sqrt(a**2 - x**2)), color=EXACT, lw=1, label="closed form")
    axes.set(xlabel="x (mm)", ylabel="pressure (MPa)", ylim=(0, 0.25))
    axes.legend()
    save()


def layer():
    """A wide flat on a thin layer: oedometer and simple shear in the middle."""
    print("Wide flat on a layer: thickness 1, E = 2, bonded; depth 0.01, drag 0.01; stress at the middle tactel")
    (left, right), save = figure("layer")
    widths = np.array([0.5, 1, 1.5, 2, 3, 4, 6, 8, 12, 16])
    for nu, mark, colour in ((0.3, "o", BLUE), (0.45, "s", ORANGE), (0.49, "^", GREEN)):
        sensor = tactel.Sensor(length=80, thickness=1, young=E, poisson=nu, tactels=81)
        oedometer, shear = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
        normal, tangential = [], []
        for a in widths:
            scene = tactel.Scene(sensor, tactel.Flat(a), tactel.bonded, tactel.Press(0.01).drag(0.01, 1))
            path = tactel.solve(scene, rung="reference")
            normal.append(-path.tactels.normal[0, 40] / (oedometer * 0.01))
            tangential.append(path.tactels.shear[1, 40] / (shear * 0.01))
        left.plot(widths, normal, mark + "-", color=colour, lw=0.8, label=f"nu = {nu}")
        right.plot(widths, tangential, mark + "-", color=colour, lw=0.8, label=f"nu = {nu}")
        film = 1 - 1 / np.cosh(widths * np.sqrt(12 * shear / oedometer))
        print(f"  nu {nu}: a/h           ", " ".join(f"{a:8g}" for a in widths))
        print("    sigma / oedometer - 1", " ".join(f"{v - 1:8.5f}" for v in normal))
        print("    thin film - 1        ", " ".join(f"{v - 1:8.5f}" for v in film))
        print("    tau / simple shear - 1", " ".join(f"{v - 1:8.5f}" for v in tangential))
    left.plot(widths, film, "--", color=EXACT, lw=0.8, label="thin film, nu = 0.49")
    for axes, what in ((left, "normal stress / oedometer"), (right, "shear stress / simple shear")):
        axes.axhline(1, color=EXACT, lw=1)
        axes.set_xscale("log")
        axes.set(xlabel="half-width / thickness", ylabel=what)
        axes.legend()
    save()


def balance():
    """Base stress, summed over tactels that tile the base, against P and Q."""
    print("Balance: sum of the stress at 200 tactels that tile the base, against P and Q; parabola R = 10, 0.15 deep")
    (left, right), save = figure("balance")
    tiles = 200
    sensor = tactel.Sensor(tactels=tiles, tactel_width=20 / tiles)
    for rung in ("patch-8", "patch-12", "patch-24", "reference", "mesh-41", "mesh-161"):
        for position in (0, 7):
            scene = tactel.Scene(sensor, tactel.Indenter(tactel.Parabola(R), position), MU,
                                 tactel.Press(0.15).drag(0.05, 4))
            path = tactel.solve(scene, rung=rung)
            normal, shear = path.tactels.normal[-1], path.tactels.shear[-1]
            P, Q = path.P[-1], path.Q[-1]
            print(f"  {rung:9} at {position}: P {P:.5f}, off by {np.sum(normal) * 20 / tiles / P + 1:.1e} P; "
                  f"Q {Q:.5f}, off by {np.sum(shear) * 20 / tiles / Q - 1:.1e} Q")
            if position == 0 and rung in ("reference", "mesh-161"):
                style = {"reference": dict(color=BLUE, lw=2.5, alpha=0.5), "mesh-161": dict(color=ORANGE, lw=1)}[rung]
                left.plot(path.tactel_x, normal, label=rung, **style)
                right.plot(path.tactel_x, shear, label=rung, **style)
    left.set(xlabel="x (mm)", ylabel="normal stress at the base (MPa)")
    right.set(xlabel="x (mm)", ylabel="shear stress at the base (MPa)")
    left.legend()
    right.legend()
    save()


def agreement():
    """A smooth contact on the patch and on fine meshes, which share the laws of contact alone."""
    print("Patch and mesh: parabola R = 10, 0.15 deep, mu 0.5, 8 drags of 0.03; mesh less `reference`, of the largest")
    (left, right), save = figure("agreement")
    for nu in (0.3, 0.45, 0.49):
        scene = tactel.Scene(tactel.Sensor(poisson=nu), tactel.Parabola(R), MU, tactel.Press(0.15).drag(0.03, 8))
        patch = tactel.solve(scene, rung="reference")
        for rung in ("mesh-321", "mesh-641"):
            mesh = tactel.solve(scene, rung=rung, precision="fp64")
            off = {"S": np.max(np.abs(mesh.slip_index[-9:] - patch.slip_index))}
            for name, one, other in (("P", mesh.P, patch.P), ("Q", mesh.Q, patch.Q),
                                     ("sigma_y", mesh.tactels.normal[:, 1:-1], patch.tactels.normal[:, 1:-1]),
                                     ("tau_xy", mesh.tactels.shear[:, 1:-1], patch.tactels.shear[:, 1:-1])):
                off[name] = np.max(np.abs(one[-9:] - other)) / np.max(np.abs(other))
            if nu == 0.45 and rung == "mesh-641":
                fine = scene.with_(load=tactel.Press(0.15, steps=80).drag(0.03, 8))
                paths = {20: patch, 80: tactel.solve(fine, rung="reference")}
                for steps, path in paths.items():
                    wiggle = np.max(np.abs(np.diff(tractions(path, -5)[1], 2)[np.abs(path.surface_x[1:-1] - 0.9) < 0.2]))
                    print(f"  shear on the patch, {steps} pressing increments: wiggle near x = 0.9: {wiggle:.4f} MPa")
            print(f"  nu {nu}, {rung}: " + ", ".join(f"{name} {value:.5f}" for name, value in off.items()))
        if nu == 0.45:
            spacing = np.diff(mesh.surface_x)[0]
            near, thin = np.abs(mesh.surface_x) < 2, slice(None, None, 3)
            for axes, fine, coarse in ((left, tractions(patch, 4)[0], mesh.normal_force[-5] / spacing),
                                       (right, tractions(patch, 4)[1], mesh.tangential_force[-5] / spacing)):
                axes.plot(mesh.surface_x[near], coarse[near], color=ORANGE, lw=1.2, label="mesh-641")
                axes.plot(patch.surface_x[thin], fine[thin], ".", color=BLUE, label="reference")
                axes.set(xlabel="x (mm)")
                axes.legend(fontsize=8)
    left.set(ylabel="pressure (MPa)", title="nu = 0.45, fourth drag")
    right.set(ylabel="shear traction (MPa)")
    save()


def convergence():
    """S on patches and meshes against the reference, over smooth contacts of several depths."""
    print("Convergence: 16 parabolas, R = 10, 0.06 to 0.3 deep, mu 0.5, 8 drags of 0.03; against `reference`")
    axes, save = figure("convergence", 1)
    scenes = [tactel.Scene(tactel.Sensor(), tactel.Parabola(R), MU, tactel.Press(depth).drag(0.03, 8))
              for depth in np.linspace(0.06, 0.3, 16)]
    solved = [tactel.solve(scene, rung="reference") for scene in scenes]
    true_s, true_p = (np.array([getattr(path, name) for path in solved]) for name in ("slip_index", "P"))
    true_normal = np.array([path.tactels.normal for path in solved])
    asked = slice(-9, None)  # meshes also return their pressing increments
    meshes = {"mesh-41": 41, "mesh-81": 81, "mesh-161": 161, "mesh-321": 321}
    for rungs, mark, colour, what in ((dict(list(ELEMENTS.items())[:4]), "o", BLUE, "elements of a patch"),
                                      (meshes, "s", ORANGE, "columns of a mesh")):
        medians = []
        for rung in rungs:
            answer = tactel.solve_many(scenes, rung=rung)
            S = np.max(np.abs(answer.slip_index[:, asked] - true_s), axis=1)
            P = np.max(np.abs(answer.P[:, asked] - true_p), axis=1) / np.max(true_p, axis=1)
            stress = (np.max(np.abs(answer.tactels.normal[:, asked] - true_normal)[:, :, 1:-1], axis=(1, 2))
                      / np.max(np.abs(true_normal), axis=(1, 2)))
            medians.append(np.median(S))
            print(f"  {rung:9}  S median {np.median(S):.5f}, largest {S.max():.5f}; P median {np.median(P):.5f}, "
                  f"largest {P.max():.5f}; sigma_y median {np.median(stress):.5f}")
        sizes = np.array(list(rungs.values()))
        slope = order(sizes, medians)
        print(f"  order in the {what}: {slope:.2f}")
        axes.loglog(sizes, medians, mark + "-", color=colour, lw=0.8, label=f"{what}, order {slope:.1f}")
    axes.set(xlabel="elements, or columns", ylabel="error of S (median)", ylim=(5e-4, 0.06))
    axes.legend()
    save()


def reversal():
    """A drag that reverses: the loop is that of the first drag at twice the scale (Masing's rule)."""
    print("Reversal: half-plane, P = 0.1, mu = 0.5, rung `reference`")
    (left, right), save = figure("reversal")
    P = 0.1
    step = drag_at(0, P) / 10
    first = np.arange(11)
    back, again = np.arange(6, -11, -2), np.arange(-8, 11, 2)
    virgin = tactel.solve(tactel.Scene(HALF_PLANE, tactel.Parabola(R), MU, tactel.Force(P).drag_to(step * first[1:])),
                          rung="reference")
    loop = tactel.solve(tactel.Scene(HALF_PLANE, tactel.Parabola(R), MU, tactel.Force(P).drag_to(
        step * np.concatenate([first[1:9], back, again]))), rung="reference")
    f = virgin.slip_index  # at 0, 1, ... 10 steps
    S = loop.slip_index
    down = f[8] - 2 * f[(8 - back) // 2]
    up = -1 + 2 * f[(again + 10) // 2]
    found_down, found_up = S[9:9 + len(back)], S[9 + len(back):]
    for name, found, law in (("way back", found_down, np.maximum(down, -1)), ("forward again", found_up, up)):
        print(f"  {name}: off the law by {np.max(np.abs(found - law)):.1e}; S at its end {found[-1]:.6f}")
    sticks = np.linspace(1, 0, 101)
    drags, closed = np.array([drag_at(c, P) for c in sticks]), 1 - sticks**2
    print(f"  first drag: S off the closed form by {np.max(np.abs(f - np.interp(step * first, drags, closed))):.6f}")
    turn = np.interp(8 * step, drags, closed)
    inside = closed <= turn  # from there on the way back is the first drag to the other side
    curves = ((drags, closed),
              (np.where(inside, 8 * step - 2 * drags, -drags), np.where(inside, turn - 2 * closed, -closed)),
              (-10 * step + 2 * drags, 2 * closed - 1))
    points = (("o", BLUE, "first drag", loop.tangential[:9], S[:9]), ("s", ORANGE, "way back", step * back, found_down),
              ("^", GREEN, "forward again", step * again, found_up))
    # Drag of a bonded contact under Q = mu P.
    bonded = SOFTNESS * MU * P * (np.log(2 * H / contact_half_width(P)) + layer_constant(1))
    for axes, part, unit in ((left, 0, 1), (right, bonded, 1000)):
        for number, (x, y) in enumerate(curves):
            axes.plot(unit * (x - part * y), y, color=EXACT, lw=1, label="closed form" if number == 0 else None)
        for mark, colour, label, x, y in points:
            axes.plot(unit * (x - part * y), y, mark, color=colour, label=label)
        axes.set(ylabel="S = Q / (mu P)", ylim=(-1.1, 1.1))
    left.set(xlabel="drag (mm)")
    right.set(xlabel="drag beyond that of a bonded contact (µm)")
    right.legend(fontsize=8)
    save()


# Pads --------------------------------------------------------------------------------------------------------------

PAD_RUNGS = {"pad-8": 8, "pad-12": 12, "pad-16": 16, "pad-24": 24}
PAD_R, PAD_D = 8.0, 0.01  # of a paraboloid on a half-space, nu = 1/2: pressing and dragging do not couple
PAD_A = np.sqrt(PAD_R * PAD_D)


def solve_pad(rung, indenter, depth, drags=(), thickness=1000 * PAD_A, poisson=0.5, young=E, friction=0.3):
    """The JSON answer of the program to one scene; drags: x (mm) and twist (degrees)."""
    scene = f"""[sensor]
kind = "pad"
tactels = [5, 1]
pitch = 1.0
thickness = {thickness}
young = {young}
poisson = {poisson}
[indenter]
{indenter}
[contact]
friction = {friction}
[load]
indentation = {depth}
"""
    if drags:
        scene += (f"tangential = [{', '.join(f'[{x}, 0]' for x, _ in drags)}]\n"
                  f"twist = [{', '.join(str(float(twist)) for _, twist in drags)}]\n")
    with tempfile.TemporaryDirectory() as folder:
        file, answer = pathlib.Path(folder) / "pad.toml", pathlib.Path(folder) / "pad.json"
        file.write_text(scene)
        program("solve", file, "--rung", rung, "--json", answer)
        return json.loads(answer.read_text())


def cells(answer):
    """x and y of the cells' middles, and their sides."""
    return np.array(answer["cell_x"]), np.array(answer["cell_y"]), answer["cell_width"]


def pad():
    """Contacts on a pad as thick as a half-space: Hertz, Mindlin, torsion, flat punch, and Dimitriadis' layer."""
    print(f"Pads: E = {E}, nu = 0.5, paraboloid of {PAD_R} mm, {PAD_D} mm deep, thickness 1000 a, mu = 0.3")
    (left, right), save = figure("pad")
    sphere = f'shape = "paraboloid"\nradii = [{PAD_R}, {PAD_R}]'
    P = 16 / 9 * E * np.sqrt(PAD_R) * PAD_D**1.5
    p0 = 3 * P / (2 * np.pi * PAD_A**2)
    shear = E / 3
    sliding = 3 * 0.3 * P * 1.5 / (16 * PAD_A * shear)
    shifts = np.arange(0.1, 1, 0.1)
    law = 1 - (1 - shifts) ** 1.5
    punch = 2 * 2.0 * 0.05 * E / 0.75
    chi = 1 / 12
    series = 1 + 1.133 * chi + 1.283 * chi**2 + 0.769 * chi**3 + 0.0975 * chi**4
    print("  rung     P, Hertz   largest p   pressure, rms   Q, Mindlin   M, torsion   P, flat punch   P, Dimitriadis")
    for rung, mark, colour in (("pad-8", "s", GREEN), ("pad-12", "o", BLUE), ("pad-16", None, None),
                               ("pad-24", ".", ORANGE)):
        answer = solve_pad(rung, sphere, PAD_D, [(part * sliding, 0) for part in shifts])
        x, y, (hx, hy) = cells(answer)
        pressure = np.array(answer["steps"][0]["normal_force"]) / (hx * hy)
        r = np.hypot(x, y)
        exact = p0 * np.sqrt(np.clip(1 - (r / PAD_A) ** 2, 0, None))
        rms = np.sqrt(np.mean((pressure - exact)[(pressure > 0) | (exact > 0)] ** 2)) / p0
        found = np.array([step["Q"][0] / (0.3 * step["P"]) for step in answer["steps"][1:]])
        turned = solve_pad(rung, sphere, PAD_D, [(0, 20)])["steps"][-1]
        flat = solve_pad(rung, 'shape = "punch"\nradius = 2.0', 0.05, thickness=2000)["steps"][0]["P"]
        layer = solve_pad(rung, sphere, PAD_D, thickness=12 * PAD_A)["steps"][0]["P"]
        torsion = 3 * np.pi / 16 * 0.3 * turned["P"] * PAD_A
        pressing = f"{answer['steps'][0]['P'] / P - 1:+.4f}    {pressure.max() / exact.max() - 1:+.4f}     {rms:.4f}"
        print(f"  {rung:7}  {pressing}          {np.max(np.abs(found - law)):.4f}       {turned['M'] / torsion - 1:+.4f}"
              f"      {flat / punch - 1:+.4f}         {layer / P / series - 1:+.4f}")
        if mark:
            part = (x > 0) & (y >= x)  # the others lie at the same r
            left.plot(r[part] / PAD_A, (pressure / p0)[part], mark, color=colour, label=rung, ms=4)
            right.plot(shifts, found, mark, color=colour, label=rung)
    r = np.linspace(0, 1, 201)
    left.plot(r, np.sqrt(1 - r**2), color=EXACT, lw=1, label="Hertz")
    left.set(xlabel="r / a", ylabel="p / p0", title="pressure of the cells", xlim=(0, 1.3))
    left.legend(fontsize=8)
    right.plot(r, 1 - (1 - r) ** 1.5, color=EXACT, lw=1, label="Cattaneo, Mindlin")
    right.set(xlabel="drag / sliding drag", ylabel="Q / (mu P)", title="partial slip")
    right.legend(fontsize=8)
    save()


def pad_line():
    """The middle of a lying cylinder 24 mm long on 1.5 mm of rubber, beside the line's own reference."""
    print("A long contact: cylinder of 8 mm, 0.2 mm deep, 1.5 mm of rubber, nu = 0.45, mu = 0.5, dragged across")
    (left, right), save = figure("pad_line")
    drags = [0.02, 0.04, 0.06]
    sensor = tactel.Sensor(length=40, thickness=1.5, young=E, poisson=0.45, tactels=5, tactel_span=4)
    line = tactel.solve(tactel.Scene(sensor, tactel.Cylinder(8.0), 0.5, tactel.Press(0.2).drag_to(drags)),
                        rung="reference")
    x, edges = elements(line)
    left.plot(x, tractions(line, -1)[0], color=EXACT, lw=1, label="line, reference")
    left.plot(x, tractions(line, -1)[1], color=EXACT, lw=1, ls="--")
    stress = np.max(np.abs(line.tactels.normal[-1]))
    print("  rung     P per length   largest p      S   sigma, tau over the largest sigma")
    worst = {}
    for rung, mark, colour in (("pad-8", None, None), ("pad-12", "s", GREEN), ("pad-16", None, None),
                               ("pad-24", "o", BLUE)):
        answer = solve_pad(rung, 'shape = "cylinder"\nradius = 8.0\nhalf_length = 12.0', 0.2, [(d, 0) for d in drags],
                           thickness=1.5, poisson=0.45, friction=0.5)
        cell_x, cell_y, (hx, hy) = cells(answer)
        middle = (cell_y > 0) & (cell_y < hy)
        errors = np.zeros(4)
        for number, step in enumerate(answer["steps"]):
            n = np.array(step["normal_force"])[middle]
            t = np.array(step["tangential_force"])[middle, 0]
            sigma = np.max(np.abs(np.array(step["sigma_z"]) - line.tactels.normal[number]))
            tau = np.max(np.abs(np.array(step["tau_x"]) - line.tactels.shear[number]))
            errors = np.maximum(errors, np.abs((n.sum() / hy / line.P[number] - 1,
                                                n.max() / hx / hy / tractions(line, number)[0].max() - 1,
                                                t.sum() / (0.5 * n.sum()) - line.slip_index[number],
                                                max(sigma, tau) / stress)))
        worst[rung] = errors
        print(f"  {rung:7}  " + " ".join(f"{error:12.4f}" for error in errors))
        if mark:
            left.plot(cell_x[middle], n / (hx * hy), mark, color=colour, label=rung, ms=4)
            left.plot(cell_x[middle], t / (hx * hy), mark, color=colour, ms=4, mfc="none")
    sizes = list(PAD_RUNGS.values())
    for column, mark, colour, label in ((0, "o", BLUE, "P per length"), (2, "^", GREEN, "S"),
                                        (3, "s", ORANGE, "base stress")):
        right.loglog(sizes, [worst[rung][column] for rung in PAD_RUNGS], mark + "-", color=colour, label=label)
    right.set(xlabel="cells along a side", ylabel="largest difference", title="line and middle of the pad")
    right.set_xticks(sizes, [str(size) for size in sizes])
    right.minorticks_off()
    right.legend(fontsize=8)
    left.set(xlabel="x (mm)", ylabel="MPa", title="pressure; open and dashed: shear")
    left.legend(fontsize=8)
    save()


SECTIONS = {section.__name__: section for section in (
    hertz, cattaneo, reversal, punch, layer, balance, convergence, agreement, pad, pad_line)}

if __name__ == "__main__":
    parser = study.options(__doc__)
    parser.add_argument("sections", nargs="*", metavar="NAME", choices=[*SECTIONS, []])
    chosen = parser.parse_args()
    program = study.Program(chosen.build)
    for name in chosen.sections or SECTIONS:
        SECTIONS[name]()
