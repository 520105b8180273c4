"""The texts of a case, by the contracts: the machine's folder, and the recordings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from .base import Array
from .machines import Machine
from .recordings import Recording

Column = tuple[str, Any, str]  # name, values, format
NAME = "machine"


def machine_files(m: Machine) -> dict[str, str]:
    """machine.toml, and of each axis its table and the table's uncertainty, by their names."""
    files = {"machine.toml": _machine_toml(m)}
    above = "# residual after compensation in the control" if m.flat else "# measured by the shop"
    for a in m.axes:
        place = (f"{a}_mm", m.nodes[a], "%.3f")
        known = [(name, y, "%.2f") for name, y in m.known[a].items()]
        files[f"{a}.csv"] = f"{above}\n" + _csv([place, *known])
        if m.states_u:
            u = [
                (name, np.full(len(y), m.U * (0.5 if "urad" in name else 1)), "%.3f")
                for name, y in m.known[a].items()
            ]
            files[f"{a}_uncertainty.csv"] = _csv([place, *u])
    return files


def _machine_toml(m: Machine) -> str:
    lines = [
        'format  = "gcomp-machine/1"',
        f'name    = "{NAME}"',
        f'title   = "{m.kind}, retrofit"',
        f'control = "{m.control}"',
        f'chain   = "{m.chain}"',
        *(['diameter = ["X"]'] if m.turning else []),
        'source  = "shop calibration"',
    ]
    for a in m.axes:
        low, high = m.travel[a]
        lines += ["", f"[axes.{a}]", f"travel = [{low!r}, {high!r}]"]
        lines += [f"least_increment = {m.increment[a]!r}", f'table  = "{a}.csv"']
        lines += [f"measured_at = {_value(m.measured_at[a])}"]
        lines += [f"max_velocity = {m.vmax[a]!r}", f"max_acceleration = {m.amax[a]!r}"]
    tables = {"squareness": m.square, "squareness.u": m.square_u, "tool": m.tool}
    if not m.states_u:
        del tables["squareness.u"]
    for name, table in tables.items():
        lines += ["", f"[{name}]", *(f"{k} = {v!r}" for k, v in table.items())]
    lines += ["", "[limits]", "max_correction = 1.0", "max_slope = 0.02", 'outside = "clamp"']
    for effect in m.declared:
        lines += ["", "[[effect]]", 'name = "backlash"', f'axis = "{effect["axis"]}"']
        lines += [f"size_um = {effect['size_um']!r}", 'source = "dial gauge"']
    return "\n".join(lines) + "\n"


def _value(value: Any) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {float(v)!r}" for k, v in value.items()) + " }"
    return repr(float(value))


def _csv(columns: Sequence[Column]) -> str:
    heads, values, formats = zip(*columns, strict=True)
    line = ",".join(formats) + "\n"
    rows: Iterable[tuple[Any, ...]] = zip(*(list(y) for y in values), strict=True)
    return ",".join(heads) + "\n" + "".join(line % row for row in rows)


def recording_file(rec: Recording) -> str:
    """The text of a recording."""
    head: dict[str, Any] = {"format": "gcomp-recording/1", "kind": rec.kind, "machine": NAME}
    head |= rec.head
    if rec.kind == "targets":
        head["sensitive"] = rec.sensitive
    if rec.kind == "trace":
        head["sees"] = rec.sees
    above = "".join(f"# {k} = {_value(v)}\n" for k, v in head.items())
    if rec.kind == "features":
        return above + _csv([*_parts(rec), *((k, y, "%.2f") for k, y in rec.more.items())])
    t = rec.t if rec.t_written is None else rec.t_written
    digits = {"targets": "%.1f", "ballbar": "%.3f", "trace": "%.5f"}[rec.kind]
    columns: list[Column] = [("run", rec.run, "%d"), ("t_s", t, digits)]
    columns += {"targets": _targets, "ballbar": _ballbar, "trace": _trace}[rec.kind](rec)
    columns += [(k, y, _format(k)) for k, y in rec.more.items()]
    return above + _csv(columns)


def _format(name: str) -> str:
    """Of a further column: currents, temperatures and forces; others as they are."""
    return {"_A": "%.4f", "_C": "%.2f", "_N": "%.2f"}.get(name[-2:], "%g")


def _reading(rec: Recording, channel: str) -> Column:
    digits = max(0, int(np.ceil(-np.log10(rec.step) - 1e-9)))
    return channel, rec.read[channel], f"%.{digits}f"


def _targets(rec: Recording) -> list[Column]:
    return [
        *((f"{a}_mm", x, "%.4f") for a, x in rec.pos.items()),
        *((f"approach_{a}", side, "%d") for a, side in rec.sense_of.items()),
        _reading(rec, "reading_um"),
    ]


def _ballbar(rec: Recording) -> list[Column]:
    place: list[Column] = [(f"{a}_cmd_mm", rec.pos[a], "%.5f") for a in rec.unit]
    return [*place, _reading(rec, "radial_um"), ("sense", rec.sense, "%d")]


def _trace(rec: Recording) -> list[Column]:
    def actual(a: str, x: Array) -> Array:
        return x + rec.read[f"{a}_act"] * 1e-3

    return [
        *((f"{a}_cmd_mm", x, "%.6f") for a, x in rec.pos.items()),
        *((f"{a}_act_mm", actual(a, x), "%.6f") for a, x in rec.pos.items()),
    ]


def _parts(rec: Recording) -> list[Column]:
    p = rec.parts
    return [
        *((k, p[k], "%s") for k in ("feature", "kind", "axis")),
        ("nominal_mm", p["nominal_mm"], "%.3f"),
        ("measured_mm", p["nominal_mm"] + rec.read["measured"] * 1e-3, "%.5f"),
        ("part", p["part"], "%d"),
        ("reading", p["reading"], "%d"),
    ]
