"""Texts of a case: machine.toml, axis tables, recordings, as the contracts want them. The layout
follows the design alone."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from proof.generator.machines import XYZ, Machine
from proof.generator.physics import Shift
from proof.generator.tracks import Track
from proof.generator.world import World


def machine_files(machine: Machine) -> dict[str, str]:
    """The map that the user has."""
    lines = [
        'format  = "gcomp-machine/1"',
        f'name    = "{machine.name}"',
        f'title   = "{machine.title}"',
        f'control = "{machine.control}"',
        f'chain   = "{machine.chain}"',
        'diameter = ["X"]' if machine.form != "mill" else "diameter = []",
        f'source  = "made up for a test; standard uncertainty of the map {machine.stated_um} um"',
        "",
    ]
    files = {}
    for x, axis in machine.axes.items():
        lines += [
            f"[axes.{x}]",
            f"travel = [{axis.low}, {axis.high}]",
            f"least_increment = {axis.least}",
            f'table  = "{x}.csv"',
        ]
        if axis.measured_at:
            lines.append(f"measured_at = {_inline(axis.measured_at)}")
        lines += [f"max_velocity = {axis.velocity}", f"max_acceleration = {axis.acceleration}", ""]
        names, columns = [f"{x}_mm"], [axis.nodes]
        for component, (forward, reverse) in axis.tables.items():
            unit = "um" if component[1] in XYZ else "urad"
            if forward is reverse:
                names.append(f"{component}_{unit}")
                columns.append(forward)
            else:
                names += [f"{component}_{unit}_fwd", f"{component}_{unit}_rev"]
                columns += [forward, reverse]
        files[f"machine/{x}.csv"] = _table(names, ["%.3f"] * len(names), columns)
    lines += ["[squareness]", *(f"{k} = {v:.6f}" for k, v in machine.square.items()), ""]
    lines += ["[tool]", *(f"{x} = {machine.tool.get(x, 0.0)}" for x in machine.axes), ""]
    lines += [
        "[offsets]",
        "G54 = " + _inline(dict.fromkeys(machine.axes, 0.0)),
        "",
        "[limits]",
        "max_correction = 0.5",
        f"max_slope = {_max_slope(machine):g}",
    ]
    return {"machine/machine.toml": "\n".join(lines) + "\n"} | files


def _max_slope(machine: Machine) -> float:
    """mm/mm that a user accepts in his machine's file: 0.005, or what his tables have."""
    steepest = max(
        float(np.abs(np.diff(values) / np.diff(axis.nodes)).max())
        for axis in machine.axes.values()
        for component, sides in axis.tables.items()
        if component[1] in XYZ
        for values in sides
    )
    return max(0.005, float(np.ceil(steepest)) * 1e-3)


def recording(
    world: World,
    track: Track,
    rows: np.ndarray,
    shift: Shift,
    channels: dict[str, bool],
    rng: np.random.Generator,
    late: float = 0.0,
    warm: float = 0.0,
) -> str:
    """One file. late: s by which its clock is off; warm: K by which its thermometers drift while it
    lasts."""
    head = [f"# {line}" for line in _head(track.head)]
    machine = world.design.machine
    if track.kind == "features":
        return "\n".join(head) + "\n" + _features(track, rows, rng)
    t = track.time + late
    names, formats, columns = (
        ["run", "t_s"],
        ["%d", "%.4f" if track.kind == "trace" else "%.3f"],
        [track.run, t],
    )

    def put(name: str, form: str, values) -> None:
        names.append(name)
        formats.append(form)
        columns.append(values)

    at = {x: track.position[:, XYZ.index(x)] for x in machine.axes}
    if track.kind == "ballbar":
        for x in track.head["centre"]:
            put(f"{x}_cmd_mm", "%.4f", at[x])
        put("radial_um", "%.1f", rows[:, 0])
        put("sense", "%d", track.sense)
    elif track.kind == "trace":
        for x in machine.axes:
            put(f"{x}_cmd_mm", "%.4f", at[x])
        for k, x in enumerate(machine.axes):
            put(f"{x}_act_mm", "%.4f", at[x] + rows[:, k] * 1e-3)
        if track.channels.get("current"):
            for x in track.moving:
                felt = shift.current.get(x, 0.0)
                put(f"{x}_current_A", "%.3f", felt + rng.normal(0, 0.06, len(t)))
    else:
        for x in machine.axes:
            put(f"{x}_mm", "%.3f", at[x])
        for x in machine.axes:
            put(f"approach_{x}", "%d", track.direction[:, XYZ.index(x)])
        put("reading_urad" if track.quantity == "angle" else "reading_um", "%.1f", rows[:, 0])
        if channels["feed"]:
            put("feed_mm_min", "%d", np.full(len(t), track.feed))
    if track.channels.get("force") and channels["force"]:
        for x in track.moving if track.kind == "trace" else track.moving[0]:
            noise = rng.normal(0, 2.0, len(t)) if track.kind == "trace" else 0.0
            put(f"force_{x}_N", "%.1f", track.force[:, XYZ.index(x)] + noise)
    if track.kind != "ballbar":
        _temperatures(world, track, channels, rng, warm, put)
        if channels["spindle"]:
            put("spindle_rpm", "%d", world.steps_at(world.rpm, track.time))
    return "\n".join(head) + "\n" + _table(names, formats, columns)


def _temperatures(world: World, track: Track, channels, rng, warm, put) -> None:
    n = len(track.time)
    drift = warm * np.linspace(0, 1, n)
    if channels["air"]:
        smooth = 0.0 if track.kind == "trace" else 1.0
        put(
            "T_air_C",
            "%.2f",
            world.at(world.air, track.time) + smooth * rng.normal(0, 0.03, n) + drift,
        )
    if track.kind == "trace":
        return
    if channels["bed"]:
        put("T_bed_C", "%.2f", world.at(world.bed, track.time) + rng.normal(0, 0.03, n))
    if channels["screw"]:
        for x in track.moving:
            put(
                f"T_screw_{x}_C",
                "%.2f",
                world.at(world.sensor(x), track.time) + rng.normal(0, 0.05, n) + drift,
            )


def _features(track: Track, rows: np.ndarray, rng: np.random.Generator) -> str:
    lines = ["feature,kind,axis,nominal_mm,measured_mm,part,reading"]
    for f, value in zip(track.features, rows[:, 0], strict=True):
        for k in range(3):
            size = f["nominal"] + (value + rng.normal(0, track.noise["sd"])) * 1e-3
            lines.append(
                f"{f['feature']},{f['kind']},{f['axis']},{f['nominal']:.4f},{size:.4f},{f['part']},{k + 1}"  # noqa: E501
            )
    return "\n".join(lines) + "\n"


def _head(head: dict) -> list[str]:
    lines = ['format = "gcomp-recording/1"']
    for key, value in head.items():
        if isinstance(value, dict):
            lines.append(f"{key} = {_inline(value)}")
        else:
            lines.append(f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value}")
    return lines


def _inline(values: dict[str, float]) -> str:
    return "{ " + ", ".join(f"{k} = {v}" for k, v in values.items()) + " }"


def _table(names: list[str], formats: list[str], columns: Iterable[np.ndarray]) -> str:
    form = ",".join(formats)
    rows = zip(*(np.asarray(c).tolist() for c in columns), strict=True)
    return ",".join(names) + "\n" + "\n".join([form % row for row in rows]) + "\n"
