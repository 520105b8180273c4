"""Texts of the machine folder and of the recordings, by the contracts."""

from __future__ import annotations

import numpy as np

from .base import AX, Array, Rec, Rng
from .machines import Machine
from .world import World, thermometer


def machine_files(m: Machine) -> dict[str, str]:
    """machine/machine.toml and the tables, stated values only."""
    names = [AX[a] for a in m.axes]
    u = f"u (k=1) of the table values {m.u:.2g} um"
    rows = [
        'format = "gcomp-machine/1"',
        f'name = "{m.name}"',
        f'title = "{m.kind}"',
        f'control = "{m.control}"',
        f'chain = "{m.chain}"',
    ]
    if "lathe" in m.kind or m.kind == "grinder":
        rows.append('diameter = ["X"]')
    rows += [f'source = "calibration report; {u}"', ""]
    files: dict[str, str] = {}
    for a in m.axes:
        lo, hi = m.travel[a]
        at = ", ".join(f"{AX[j]} = {m.measured[a][j]:.1f}" for j in m.axes if j != a)
        rows += [
            f"[axes.{AX[a]}]",
            f"travel = [{lo:.1f}, {hi:.1f}]",
            "least_increment = 0.0001",
            f'table = "{AX[a]}.csv"',
            f"measured_at = {{ {at} }}",
            f"max_velocity = {m.vmax:.1f}",
            f"max_acceleration = {m.amax:.1f}",
            "",
        ]
        head, cols = [f"{AX[a]}_mm"], [m.nodes[a]]
        for comp, (f, b) in m.tables[a].items():
            unit = "um" if comp[1] in AX else "urad"
            if np.array_equal(f, b):
                head, cols = [*head, f"{comp}_{unit}"], [*cols, f]
            else:
                head += [f"{comp}_{unit}_fwd", f"{comp}_{unit}_rev"]
                cols += [f, b]
        files[f"machine/{AX[a]}.csv"] = csv(head, [col(c, 3) for c in cols])
        if m.u_file:
            big = [col(m.nodes[a], 3)] + [col(np.full(len(m.nodes[a]), 2 * m.u), 3)] * (
                len(cols) - 1
            )
            files[f"machine/{AX[a]}_uncertainty.csv"] = csv(head, big)
    rows.append("[squareness]")
    rows += [f"{k} = {v:.2f}" for k, v in m.square.items()]
    rows += ["", "[tool]"] + [f"{n} = {m.tool[AX.index(n)]:.1f}" for n in names]
    rows += ["", "[limits]", "max_correction = 2.0", "max_slope = 0.01"]
    return {"machine/machine.toml": "\n".join(rows) + "\n", **files}


def col(x: Array, decimals: int) -> list[str]:
    """Formatted column."""
    return np.char.mod(f"%.{decimals}f", np.asarray(x, float) + 0.0).tolist()


def whole(x: Array) -> list[str]:
    """Formatted column of integers."""
    return [str(int(v)) for v in x]


def csv(head: list[str], cols: list[list[str]]) -> str:
    """Header and rows."""
    return ",".join(head) + "\n" + "\n".join(map(",".join, zip(*cols, strict=False))) + "\n"


def vec(v: Array, axes: list[int]) -> str:
    """Inline TOML table of a vector."""
    return "{ " + ", ".join(f"{AX[a]} = {v[a]:.9g}" for a in axes) + " }"


def recording(
    rec: Rec,
    w: World,
    value: Array,
    u: float | None,
    r: Rng,
    hide: set[str],
    current: dict[int, Array],
    gone: Array | None = None,
) -> tuple[str, dict]:
    """Text of one file from its channel values (um; channels x readings) and thermometer notes.

    Rows where `gone` is true were taken, but are missing in the file.
    """
    m, meta = w.machine, rec.meta
    top = [
        'format = "gcomp-recording/1"',
        f'kind = "{rec.kind}"',
        f'machine = "{m.name}"',
        f'instrument = "{meta["instrument"]}"',
    ]
    if u is not None:
        top.append(f"u_um = {u:.3g}")
    head: list[str] = []
    cols: list[list[str]] = []

    def add(name: str, c: list[str]) -> None:
        head.append(name)
        cols.append(c)

    if rec.kind == "features":
        info = meta["info"]
        for name, c in (
            ("feature", [f"f{i[0]}" for i in info]),
            ("kind", [i[1] for i in info]),
            ("axis", [AX[i[2]] for i in info]),
            ("nominal_mm", [f"{i[3]:.3f}" for i in info]),
            (
                "measured_mm",
                [f"{i[3] + v / 1e3:.6f}" for i, v in zip(info, value[0], strict=False)],
            ),
            ("part", [str(i[4]) for i in info]),
            ("reading", [str(i[5]) for i in info]),
        ):
            add(name, c)
        return text(top, head, cols), {}
    add("run", whole(rec.run))
    add("t_s", col(rec.t, 5 if rec.kind == "trace" else 4))
    if rec.kind == "targets":
        angle = meta["quantity"] == "angle"
        top.append(f'quantity = "{meta["quantity"]}"')
        top.append(
            "sensitive = "
            + (vec(meta["rotvec"], [0, 1, 2]) if angle else vec(meta["sensitive"], rec.axes))
        )
        for a in rec.axes:
            add(f"{AX[a]}_mm", col(rec.pos[:, a], 4))
        for a in rec.axes:
            add(f"approach_{AX[a]}", whole(rec.sgn[:, a]))
        add("reading_urad" if angle else "reading_um", col(value[0], 3))
        if w.record["feed"]:
            add("feed_mm_min", col(rec.feed, 1))
    elif rec.kind == "ballbar":
        plane = meta["plane"]
        top += [
            "centre = " + vec(meta["centre"], plane),
            f"radius_mm = {meta['radius']:.1f}",
            f"feed_mm_min = {meta['feed']:.1f}",
        ]
        for a in plane:
            add(f"{AX[a]}_cmd_mm", col(rec.pos[:, a], 6))
        add("radial_um", col(value[0], 3))
        add("sense", whole(meta["sense"]))
        rest = [a for a in rec.axes if a not in plane]
        top += [f"at = {vec(meta['centre'], rest)}"] if rest else []
    else:
        top.append(f'sees = "{meta["sees"]}"')
        for a in rec.axes:
            add(f"{AX[a]}_cmd_mm", col(rec.pos[:, a], 6))
        for i, a in enumerate(rec.axes):
            add(f"{AX[a]}_act_mm", col(rec.pos[:, a] + value[i] / 1e3, 6))
        for a, c in current.items():
            add(f"{AX[a]}_current_A", col(c, 3))
    if w.rpm.any() and "rpm" not in hide:
        add("spindle_rpm", col(w.step(w.rpm, rec.t), 0))
    if any(v.any() for v in w.load.values()) and "load" not in hide and rec.kind != "ballbar":
        for a in rec.axes:
            name = f"load_{AX[a]}_N" if rec.kind == "targets" else f"force_{AX[a]}_N"
            f = w.force(rec, a)
            add(name, col(f + r.normal(0, 0.5, len(f)), 1))
    notes = {}
    if w.record["T"] and "T" not in hide:
        places = {"T_air_C": w.air}
        places |= {f"T_screw_{AX[a]}_C": w.screw[a] + 0.5 * w.air for a in rec.axes}
        if w.record["frame"]:
            places["T_frame_C"] = w.frame
        if w.rpm.any():
            places["T_spindle_C"] = w.spindle + 0.5 * w.air
        for name, series in places.items():
            if name in hide:
                continue
            v, note = thermometer(r, w.at(series, rec.t), rec.t, w.family)
            add(name, col(v, 2))
            notes[name] = note
    if gone is not None:
        cols = [[c[i] for i in np.flatnonzero(~gone)] for c in cols]
    return text(top, head, cols), notes


def text(top: list[str], head: list[str], cols: list[list[str]]) -> str:
    """A recording: commented TOML, header, rows."""
    return "".join(f"# {line}\n" for line in top) + csv(head, cols)
