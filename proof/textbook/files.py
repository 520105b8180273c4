"""The texts of a case, by the contracts: the machine's folder, and the recordings."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from .base import Array, Fields, Rng
from .machines import Machine
from .recordings import Recording, round_to

Column = tuple[str, Array, str]  # name, values, format


def machine_files(m: Machine) -> dict[str, str]:
    """machine.toml, and of each axis its table and the table's uncertainty, by their names."""
    files = {"machine.toml": _machine_toml(m)}
    for a in m.axes:
        head, columns = [f"{a}_mm"], [m.nodes[a]]
        u_head, u_columns = [f"{a}_mm"], [m.nodes[a]]
        for name, (forward, backward) in m.known[a].items():
            pairs = [(f"{name}_fwd", forward), (f"{name}_rev", backward)]
            if np.array_equal(forward, backward):
                pairs = [(name, forward)]
            for title, y in pairs:
                head.append(title)
                columns.append(y)
                u_head.append(title)
                u_columns.append(np.full(len(y), m.u[a][name]))
        files[f"{a}.csv"] = _csv("# simulated calibration\n", head, columns, ["%.3f"] * len(head))
        if m.states_u:
            files[f"{a}_uncertainty.csv"] = _csv(
                "# U, 95 %\n", u_head, u_columns, ["%.3f"] * len(u_head)
            )
    return files


def _machine_toml(m: Machine) -> str:
    chain = ["w", *m.work_side, "b", *m.tool_side, "t"]
    lines = [
        'format  = "gcomp-machine/1"',
        f'name    = "{m.name}"',
        f'title   = "{m.kind}, simulated"',
        f'control = "{m.control}"',
        f'chain   = "{"-".join(chain)}"',
        f"diameter = {json.dumps(m.diameter)}",
        'source  = "world beyond, simulated calibration"',
        "",
    ]
    for a in m.axes:
        lines += [
            f"[axes.{a}]",
            f"travel = [{m.travel[a][0]}, {m.travel[a][1]}]",
            f"least_increment = {m.increment:.4f}",
            f'table  = "{a}.csv"',
        ]
        if m.measured_at[a]:
            lines.append(f"measured_at = {_inline(m.measured_at[a])}")
        lines += [f"max_velocity = {m.maxv[a]}", f"max_acceleration = {m.maxa[a]}", ""]
    lines += ["[squareness]", *(f"{k} = {v}" for k, v in m.square.items())]
    if m.states_u:
        lines += ["", "[squareness.u]", *(f"{k} = {v}" for k, v in m.square_u.items())]
    lines += ["", "[tool]", *(f"{a} = {m.tool[a]}" for a in m.axes)]
    lines += ["", "[offsets]", f"G54 = {_inline(dict.fromkeys(m.axes, 0.0))}"]
    lines += ["", "[limits]", "max_correction = 0.5", "max_slope = 0.005", 'outside = "clamp"', ""]
    for effect in m.declared:
        lines += ["[[effect]]", *(f"{k} = {json.dumps(v)}" for k, v in effect.items()), ""]
    return "\n".join(lines)


def _inline(values: dict[str, float]) -> str:
    return "{ " + ", ".join(f"{k} = {v}" for k, v in values.items()) + " }"


def _csv(above: str, head: Sequence[str], columns: Sequence[Array], formats: Sequence[str]) -> str:
    row = ",".join(formats) + "\n"
    values = zip(*(np.asarray(c).tolist() for c in columns), strict=True)
    return above + ",".join(head) + "\n" + "".join(row % v for v in values)


def recording_file(rec: Recording, signal: Fields, r: Rng) -> str:
    """The text of a recording; signal: channel -> um. r: the noise of the drives' currents."""
    above = "".join(f"# {k} = {_value(v)}\n" for k, v in rec.head.items())
    if rec.kind == "features":
        return above + _parts(rec, signal["r"])
    t = rec.t if rec.t_written is None else rec.t_written
    columns = [("run", rec.run, "%d"), ("t_s", t, "%.1f" if rec.kind == "targets" else "%.5f")]
    columns += {"targets": _targets, "ballbar": _ballbar, "trace": _trace}[rec.kind](rec, signal, r)
    columns += [(name, y, _format(name)) for name, y in rec.more.items()]
    heads, values, formats = zip(*columns, strict=True)
    return _csv(above, heads, values, formats)


def _format(name: str) -> str:
    """Of a further column: temperatures, the air's pressure, feeds, speeds and forces."""
    return "%.2f" if name.startswith("T_") else "%.3f" if "hPa" in name else "%.1f"


def _value(value: object) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{a} = {float(b):.9g}" for a, b in value.items()) + " }"
    return json.dumps(value) if isinstance(value, str) else str(value)


def _targets(rec: Recording, signal: Fields, r: Rng) -> list[Column]:
    side = {a: np.where(rec.sense_of[a] >= 0, 1, -1) for a in rec.axes}
    return [
        *((f"{a}_mm", rec.pos[a], "%.4f") for a in rec.axes),
        *((f"approach_{a}", side[a], "%d") for a in rec.axes),
        ("reading_um", round_to(signal["r"], rec.step), "%.4f"),
    ]


def _ballbar(rec: Recording, signal: Fields, r: Rng) -> list[Column]:
    return [
        *((f"{a}_cmd_mm", rec.pos[a], "%.5f") for a in rec.plane),
        ("radial_um", round_to(signal["r"], rec.step), "%.4f"),
        ("sense", rec.sense, "%d"),
    ]


def _trace(rec: Recording, signal: Fields, r: Rng) -> list[Column]:
    columns = [(f"{a}_cmd_mm", rec.pos[a], "%.7f") for a in rec.axes]
    for a in rec.axes:
        actual = rec.pos[a] + signal[a] * 1e-3
        # in this order, for the same last digit
        counted = np.round(actual / (rec.step * 1e-3)) * rec.step * 1e-3
        columns.append((f"{a}_act_mm", counted, "%.7f"))
    for a, c in rec.current.items():
        columns.append((f"{a}_current_A", c + r.normal(0, 0.02, rec.n), "%.4f"))
    return columns


def _parts(rec: Recording, signal: Array) -> str:
    p = rec.parts
    measured = p["nominal"] + round_to(signal, rec.step) * 1e-3
    rows = zip(
        p["feature"], p["kind"], p["axis"], p["nominal"], measured, p["part"], p["reading"],
        strict=True,
    )  # fmt: skip
    return "feature,kind,axis,nominal_mm,measured_mm,part,reading\n" + "".join(
        f"{f},{kind},{a},{nominal:.4f},{y:.6f},{part},{reading}\n"
        for f, kind, a, nominal, y, part, reading in rows
    )
