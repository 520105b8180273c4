"""Small models of controls: what each adds to a command, from the text that it would load. Written
from the manuals' facts, none of gcomp's readers in it. `turn` -1 reads every value of the file with
its sign turned.

A model is called with the moving and the corrected axis, commands (N,) mm and the direction of the
last move, and gives (N,) mm. What it does not understand it refuses with an assertion.
"""

from __future__ import annotations

import re

import numpy as np

INCH = 25.4


def linuxcnc(files: dict[str, bytes], kind: str, unit: float = 1.0, turn: float = 1.0):
    """usrmotintf stops at the first line without three numbers; command.c refuses what does not
    ascend and more than 256; trims are single precision; control.c adds the trim of the joint's
    direction."""
    loaded = {}
    for name, data in files.items():
        rows: list[list[float]] = []
        for line in data.decode().splitlines():
            words = re.match(r"\s*([-+.\deE]+)\s+([-+.\deE]+)\s+([-+.\deE]+)", line)
            if words is None:
                break
            row = [float(w) for w in words.groups()]
            assert not rows or row[0] > rows[-1][0], "compensation values must increase"
            assert len(rows) < 256, "too many compensation entries"
            rows.append(row)
        nominal, forward, reverse = np.array(rows).T
        if kind == "0":
            forward, reverse = nominal - forward, nominal - reverse
        loaded[name[0]] = nominal, np.float32(turn * forward), np.float32(turn * reverse)

    def added(moving, along, command, way):
        nominal, forward, reverse = loaded[moving]
        assert moving == along
        return np.interp(command / unit, nominal, forward if way > 0 else reverse) * unit

    return added


def enc_comp(files: dict[str, bytes], notices, unit: float = 1.0, turn: float = 1.0):
    """K3: a positive value moves the axis in the negative direction; MD32450 is added once at a
    reversal (half here, half there, which is the same but for the zero)."""
    text = files["AX_EEC.INI"].decode()
    assert text.endswith("M17\n")
    heads = dict(re.findall(r"_(STEP\[0,\w+\]|MIN\[0,\w+\]|MAX\[0,\w+\])=(\S+)", text))
    values: dict[str, list[float]] = {}
    for i, name, value in re.findall(r"\$AA_ENC_COMP\[0,(\d+),(\w)1\]=(\S+)", text):
        assert int(i) == len(values.setdefault(name, []))
        values[name].append(float(value))
    play = {}
    for notice in notices:
        found = re.match(r"E(.)\1: the table is the mean.*MD32450 \(backlash\) = (\S+)", notice)
        if found:
            play[found[1]] = float(found[2])

    def added(moving, along, command, way):
        assert moving == along
        low, step = (float(heads[f"{k}[0,{moving}1]"]) for k in ("MIN", "STEP"))
        points = low + step * np.arange(len(values[moving]))
        assert abs(points[-1] - float(heads[f"MAX[0,{moving}1]"])) < 1e-6
        table = np.interp(command / unit, points, values[moving])
        return turn * (way * play.get(moving, 0.0) / 2 - table) * unit

    return added


def cec(files: dict[str, bytes], unit: float = 1.0, turn: float = 1.0):
    """K3: the value is added to the output axis over the position of the input axis; DIRECTION 1,
    -1, 0 for both."""
    text = files["NC_CEC.INI"].decode()
    tables = {}
    for t in set(re.findall(r"\$AN_CEC\[(\d+),", text)):
        one = dict(re.findall(rf"\$AN_CEC_(\w+)\[{t}\]=\(?([\w.+-]+)\)?", text))
        values = [float(v) for v in re.findall(rf"\$AN_CEC\[{t},\d+\]=(\S+)", text)]
        assert one["MULT_BY_TABLE"] == one["IS_MODULO"] == "0"
        points = float(one["MIN"]) + float(one["STEP"]) * np.arange(len(values))
        assert abs(points[-1] - float(one["MAX"])) < 1e-6
        axes = tuple("XYZ"[int(one[k][2]) - 1] for k in ("INPUT_AXIS", "OUTPUT_AXIS"))
        tables[t] = (*axes, int(one["DIRECTION"]), points, np.array(values))

    def added(moving, along, command, way):
        total = np.zeros_like(command)
        for base, corrected, direction, points, values in tables.values():
            if (base, corrected) == (moving, along) and direction in (0, way):
                total += turn * np.interp(command / unit, points, values) * unit
        return total

    return added


def fanuc(
    text: str, home: dict[str, float], step: float, increment: float, axes: str, turn: float = 1.0
):
    """B-63980EN page 100: number n is put out between the points n-1 and n, detection unit x 3623;
    A-77810E: numbers from 3626 on for travel in -, 3627 at the reference from the other side; 1851
    at a reversal."""
    parameter, pitch = {}, {}
    for number, axis, value in re.findall(r"N(\d+) P(\d) R(-?[\d.]+)", text):
        length = 1 / increment if "." in value else 1.0
        parameter[int(number), axes[int(axis) - 1]] = float(value) * length
    for number, value in re.findall(r"N1(\d{4}) R(-?\d+)", text):
        assert int(number) not in pitch
        pitch[int(number)] = int(value)

    def added(moving, along, command, way):
        assert moving == along
        p = {n: v for (n, a), v in parameter.items() if a == moving}
        start = int(p[3626]) if way < 0 and 3626 in p else int(p[3621])
        reference = start + int(p[3620] - p[3621])
        numbers = np.arange(start, start + int(p[3622] - p[3621]) + 1)
        points = (
            home.get(moving, 0.0)
            + (np.arange(start - 1, numbers[-1] + 1) - reference) * p[3624] * increment
        )
        sums = np.concatenate([[0], np.cumsum([pitch[n] for n in numbers])]) * p[3623] * step
        at = home.get(moving, 0.0)
        other = p.get(3627, 0) * step if way < 0 and 3626 in p else 0.0
        value = np.interp(command, points, sums) - np.interp(at, points, sums) + other
        return turn * (value + way * p[1851] * step / 2)

    return added


def heidenhain(files: dict[str, bytes], unit: float = 1.0, turn: float = 1.0):
    """MANUALplus 620 pages 716 to 718: AXISPOS, a column for each corrected axis, BACKLASH for
    travel in -; .CMA: the column of the moving axis names its .COM. Positive where the axis travels
    too far, so it is taken away."""
    if "config.CMA" in files:
        head, row = (line.split() for line in files["config.CMA"].decode().splitlines()[1:3])
        assigned = dict(zip(head[1:-1], row[1:-1], strict=True))
        assert row[-1] == "*"
    else:
        assigned = {name[5]: name for name in files}
    tables = {}
    for moving, name in assigned.items():
        lines = files[name].decode().splitlines()
        assert lines[0].startswith("BEGIN") and lines[-1].startswith("[END]")
        names = lines[1].split()
        assert names[:2] == ["NR", "AXISPOS"]
        rows = np.array([[float(w) for w in line.split()] for line in lines[2:-1]])
        assert rows.shape[1] == len(names) and len(rows) <= 256
        tables[moving] = dict(zip(names, rows.T, strict=True))

    def added(moving, along, command, way):
        table = tables[moving]
        column = "BACKLASH" if way < 0 and along == moving and "BACKLASH" in table else along
        return -turn * np.interp(command / unit, table["AXISPOS"], table[column]) * unit

    return added


def _rows(data: bytes) -> list[list[str]]:
    lines = [line for line in data.decode().splitlines() if not line.startswith("#")]
    return [line.split(",") for line in lines[1:]]


def haas(data: bytes, home: dict[str, float], turn: float = 1.0):
    """96-8000 page 305: every 0.5 inch from machine zero towards minus, inches; taken as added to
    the command."""

    def added(moving, along, command, way):
        values = [float(r[3]) * INCH for r in _rows(data) if r[0] == moving]
        points = home[moving] - 0.5 * INCH * np.arange(len(values))
        return turn * np.interp(command, points[::-1], values[::-1])

    return added


def fagor(data: bytes, unit: float = 1.0, turn: float = 1.0):
    """8055 page 328: the error of each direction is taken away; all zero in -: that of + for
    both."""

    def added(moving, along, command, way):
        table = np.array([[float(v) for v in r[1:]] for r in _rows(data) if r[0] == moving]).T
        column = table[2] if way < 0 and table[2].any() else table[1]
        return -turn * np.interp(command / unit, table[0], column) * unit

    return added


def mitsubishi(data: bytes, step: float, turn: float = 1.0):
    """E68 page 292: increments of half output units between division points, zero at the
    reference."""

    def added(moving, along, command, way):
        table = np.array([[float(v) for v in r[1:]] for r in _rows(data) if r[0] == moving]).T
        assert table[2].min() >= -128 and table[2].max() <= 127
        total = np.cumsum(table[2]) * step / 2
        return turn * np.interp(command, table[1], total - np.interp(0.0, table[0], total))

    return added
