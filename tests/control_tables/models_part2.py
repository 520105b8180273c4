"""Small models of controls, written from their documents and sources, not from gcomp's readers.

Each takes the text that a control would load and gives where the control sends the slides. What it
does not know it refuses with an assertion.
"""

from __future__ import annotations

import re

import numpy as np

XYZ = "XYZ"


# -- Beckhoff and ISG: leadscrew list --------------------------------------------------------------


def lsec(text: str):
    """TF5200: value = actual - setpoint in 0.1 um; the setpoint is changed so that it is gone;
    linear; held beyond."""
    entries = {}
    for line in text.splitlines():
        words = line.split("#")[0].split()
        if words:
            assert len(words) == 2, line
            entries[words[0]] = words[1]
    assert entries["kw.ssfk.unit"] == "1"
    n = int(entries["kw.ssfk.kw_nr_max"])
    gap, first = int(entries["kw.ssfk.interval"]), int(entries["kw.ssfk.kw_startpos"])
    at = [
        first + gap * i if gap else int(entries[f"kw.ssfk.table[{i}].setpoint"]) for i in range(n)
    ]
    pos = [int(entries[f"kw.ssfk.table[{i}].pos"]) for i in range(n)]
    neg = (
        [int(entries[f"kw.ssfk.table[{i}].neg"]) for i in range(n)]
        if entries["kw.ssfk.bilateral"] == "1"
        else pos
    )

    def sent(command, way):
        return command - np.interp(command * 1e4, at, pos if way > 0 else neg) * 1e-4

    return sent


# -- ISG VolComp -----------------------------------------------------------------------------------


def isg_parameters(text: str) -> dict:
    """TF5280, "ISG CSV format": parameter to a function of the axes; GRID: linear along every
    argument, held beyond."""
    found = {}
    for block in re.split(r"^#.*$", re.sub(r"//.*", "", text), flags=re.MULTILINE):
        rows = [line.split() for line in block.splitlines() if line.split()]
        names, data = rows[0], np.array([[float(c) for c in row] for row in rows[1:]])
        arguments = [name for name in names if len(name) == 1]
        for name in names:
            if len(name) > 1:
                assert name not in found
                found[name] = _grid(
                    arguments,
                    data[:, [names.index(a) for a in arguments]],
                    data[:, names.index(name)],
                )
    return found


def _grid(arguments, places, values):
    if not arguments:
        assert len(values) == 1
        return lambda q: values[0]
    if len(arguments) == 1:
        return lambda q: np.interp(q[arguments[0]], places[:, 0], values)
    assert len(arguments) == 2
    first = np.unique(places[:, 0])
    lines = [places[:, 0] == p for p in first]
    return lambda q: np.interp(
        q[arguments[0]], first, [np.interp(q[arguments[1]], places[m, 1], values[m]) for m in lines]
    )


def etalon_parameters(text: str) -> dict:
    """TF5280, "Etalon Exchange Format": [NAME] and VALUE or Gridpoints."""
    found = {}
    for name, body in re.findall(r"\[(\w+)\]([^\[]*)", re.sub(r"//.*", "", text)):
        if "VALUE" in body:
            found[name] = _grid([], None, [float(body.split("=")[1])])
            continue
        data = np.array(
            [float(w) for w in body[body.index("{") + 1 : body.index("}")].split()]
        ).reshape(-1, 2)
        found[name] = _grid([name[2]], data[:, :1], data[:, 1])
    return found


def volcomp(parameters: dict, chain: str, workpiece_axes: int):
    """Where VolComp sends the slides: the command less the deviation of the ISO 230-1 model.

    The model is the product of homogeneous transforms from the workpiece to the tool tip: an axis
    of the workpiece's side errs before it moves, one of the tool's side after. Errors are taken a
    thousandth as large and the result a thousand times, so that what is left of second order is
    nothing.
    """
    scale = 1e-3

    def value(name, q):
        return scale * parameters[name](q) if name in parameters else 0.0

    def deviation(place):
        q = dict(zip(XYZ, place, strict=True))
        pose = np.eye(4)
        for index, x in enumerate(chain):
            u = np.eye(3)[XYZ.index(x)]
            lean = np.array([value(f"{r}0{x}", q) for r in "ABC"])
            move = np.eye(4)
            move[:3, 3] = (u + np.cross(lean, u)) * q[x]
            a, b, c = (value(f"E{r}{x}", q) for r in "ABC")
            error = np.eye(4)
            error[:3, :3] += [[0, -c, b], [c, 0, -a], [-b, a, 0]]
            error[:3, 3] = [value(f"E{d}{x}", q) for d in XYZ]
            pose = pose @ (error @ move if index < workpiece_axes else move @ error)
        return (pose[:3, 3] - np.array(place)) / scale

    return deviation


def listing(text: str) -> dict:
    """A VolComp list: a name and a value a line."""
    return dict(line.split() for line in text.splitlines() if line.strip())


# -- printers --------------------------------------------------------------------------------------


class Marlin:
    """planner.h: skew(); M852.cpp; backlash.cpp: the distance is added in the new direction, the
    start counts as +."""

    def __init__(self, text: str):
        self.xy = self.xz = self.yz = 0.0
        self.lost = dict.fromkeys(XYZ, 0.0)
        metric = False
        for line in text.splitlines():
            words = line.split(";")[0].split()
            metric |= words[:1] == ["G21"]
            if words[:1] == ["M852"]:
                assert metric, "value_linear_units()"
                values = {w[0]: float(w[1:]) for w in words[1:]}
                assert all(-1 <= v <= 1 for v in values.values())
                self.xy, self.xz, self.yz = (
                    values.get("I", 0.0),
                    values.get("J", 0.0),
                    values.get("K", 0.0),
                )
            if words[:1] == ["M425"]:
                values = {w[0]: float(w[1:]) for w in words[1:]}
                fraction = values.pop("F")
                self.lost.update({x: fraction * v for x, v in values.items()})

    def sent(self, place, way):
        x, y, z = place
        skewed = np.array([x - y * self.xy - z * (self.xz - self.xy * self.yz), y - z * self.yz, z])
        return skewed - [self.lost[a] if w < 0 else 0.0 for a, w in zip(XYZ, way, strict=True)]


class Klipper:
    """skew_correction.py: calc_skew_factor, calc_skew."""

    def __init__(self, text: str):
        self.factor = {"XY": 0.0, "XZ": 0.0, "YZ": 0.0}
        for line in text.splitlines():
            words = line.split(";")[0].split()
            if words[:1] == ["SET_SKEW"]:
                for word in words[1:]:
                    plane, lengths = word.split("=")
                    ac, bd, ad = (float(v) for v in lengths.split(","))
                    side = np.sqrt(2 * ac * ac + 2 * bd * bd - 4 * ad * ad) / 2
                    angle = np.arccos((ac * ac - side * side - ad * ad) / (2 * side * ad))
                    self.factor[plane] = np.tan(np.pi / 2 - angle)

    def sent(self, place, way):
        x, y, z = place
        xy, xz, yz = (self.factor[p] for p in ("XY", "XZ", "YZ"))
        return np.array([x - y * xy - z * (xz - xy * yz), y - z * yz, z])


class RepRap:
    """Move.cpp: AxisTransform adds; GCodes2.cpp, case 556: value / S, X is XY, Y is YZ, Z is XZ."""

    def __init__(self, text: str):
        self.tan = dict.fromkeys(XYZ, 0.0)
        self.lost = dict.fromkeys(XYZ, 0.0)
        for line in text.splitlines():
            words = line.split(";")[0].split()
            values = {w[0]: float(w[1:]) for w in words[1:]}
            if words[:1] == ["M556"]:
                height = values["S"]
                assert height >= 10 and values.get("P", 0) <= 0
                self.tan = {x: values[x] / height for x in XYZ}
            if words[:1] == ["M425"]:
                assert all(v >= 0 for v in values.values())
                self.lost.update(values)

    def sent(self, place, way):
        x, y, z = place
        moved = np.array([x + self.tan["X"] * y + self.tan["Z"] * z, y + self.tan["Y"] * z, z])
        return moved - [self.lost[a] if w < 0 else 0.0 for a, w in zip(XYZ, way, strict=True)]


# -- tables of one axis ----------------------------------------------------------------------------


def nc_studio(text: str):
    """Axis to where the slide is sent: nominal less the error of the direction, from the manual's
    rows."""
    rows, axis = {}, ""
    for line in text.splitlines():
        if line.startswith("["):
            axis = line.strip("[] ")
            rows[axis] = []
        elif axis and line.strip() and not line.startswith(";"):
            rows[axis].append([float(c) for c in line.split(",")])
    tables = {x: np.array(r).T for x, r in rows.items()}
    return lambda x, command, way: (
        command - np.interp(command, tables[x][0], tables[x][1 if way > 0 else 2])
    )


def typed(text: str):
    """A person who types a sheet in: start, length and points to the even places, the columns in
    their order."""
    head, rows = {}, []
    for line in text.splitlines():
        if "=" in line and not line.startswith("#"):
            key, value = line.split("=")
            head[key.strip()] = value.strip()
        elif line[:1].isdigit() or line[:1] == "-":
            rows.append([float(c) for c in line.split(",")])
    unit = {"mm": 1.0, "inch": 25.4}[head["unit"]]
    places = float(head["start"]) + float(head["length"]) * np.arange(int(head["points"])) / (
        int(head["points"]) - 1
    )
    data = np.array(rows).T
    return places * unit, data[1] * unit, data[-1] * unit


def centroid_one(text: str, counts_per_mm: float):
    """Version 1: number of points, place of the last in counts from home; a correction in counts at
    each."""
    lines = text.split()
    n, last = int(lines[0]), int(lines[1])
    assert len(lines) == n + 2
    places, values = (
        np.linspace(0, last, n) / counts_per_mm,
        np.array([int(v) for v in lines[2:]]) / counts_per_mm,
    )
    order = np.argsort(places)
    return lambda command: command + np.interp(command, places[order], values[order])
