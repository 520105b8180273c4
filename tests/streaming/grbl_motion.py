"""What the model of GRBL does with places: arcs as chords ($12 mm), reports of machine or work
positions, mm or inch."""

from __future__ import annotations

import math

CHORD = 0.002
PLANES = {"17": (0, 1, 2), "18": (2, 0, 1), "19": (1, 2, 0)}


def target(model, codes: list[str], number: dict[str, float], unit: float) -> list[float]:
    """Where a block goes, mm, machine coordinates. G28 and G30 end at the zero (their stored
    places)."""
    end = list(model.target)
    for i, axis in enumerate("XYZ"):
        if axis in number:
            value = number[axis] * unit
            if "53" in codes:
                end[i] = value
            elif model.modal["distance"] == "91":
                end[i] += value
            else:
                shift = model.stored[model.modal["work"]][i] + model.preset[i]
                end[i] = value + shift + (model.length if i == 2 else 0.0)
    return [0.0, 0.0, 0.0] if {"28", "30"} & set(codes) else end


def way(
    start: list[float],
    end: list[float],
    number: dict[str, float],
    motion: str,
    plane: str,
    unit: float,
) -> list[list[float]]:
    """Places behind the start: the end, and before it those on an arc (G2, G3 with centre or
    radius; NIST RS274NGC 3.5.3)."""
    if motion not in "23" or not {"I", "J", "K", "R"} & set(number):
        return [end]
    a, b, c = PLANES[plane]
    if "R" in number:
        dx, dy = end[a] - start[a], end[b] - start[b]
        half, radius = math.hypot(dx, dy) / 2, abs(number["R"]) * unit
        side = math.sqrt(max(radius**2 - half**2, 0.0)) / (2 * half)
        side *= (-1 if motion == "2" else 1) * (1 if number["R"] > 0 else -1)
        centre = (start[a] + dx / 2 - dy * side * 1.0, start[b] + dy / 2 + dx * side * 1.0)
    else:
        centre = (
            start[a] + number.get("IJK"[a], 0.0) * unit,
            start[b] + number.get("IJK"[b], 0.0) * unit,
        )
    radius = math.hypot(start[a] - centre[0], start[b] - centre[1])
    first = math.atan2(start[b] - centre[1], start[a] - centre[0])
    sweep = math.atan2(end[b] - centre[1], end[a] - centre[0]) - first
    sweep = sweep % (2 * math.pi) or 2 * math.pi
    if motion == "2":
        sweep = sweep - 2 * math.pi or -2 * math.pi
    n = max(1, math.ceil(abs(sweep) / (2 * math.sqrt(2 * CHORD / max(radius, CHORD)))))
    places = []
    for i in range(1, n):
        place = [0.0, 0.0, 0.0]
        place[a] = centre[0] + radius * math.cos(first + sweep * i / n)
        place[b] = centre[1] + radius * math.sin(first + sweep * i / n)
        place[c] = start[c] + (end[c] - start[c]) * i / n
        places.append(place)
    return [*places, end]


def report(model, state: str) -> str:
    """A report as $10 and $13 ask for it: bit 0 machine positions, else work positions with a WCO
    now and then."""
    per = 25.4 if model.settings["13"] == "1" else 1.0
    digits = 4 if per > 1 else 3
    work = [s + p for s, p in zip(model.stored[model.modal["work"]], model.preset, strict=True)]
    work[2] += model.length

    def said(place: list[float]) -> str:
        return ",".join(f"{v / per:.{digits}f}" for v in place)

    machine = int(model.settings["10"]) & 1
    where = (
        f"MPos:{said(model.place)}"
        if machine
        else f"WPos:{said([p - w for p, w in zip(model.place, work, strict=True)])}"
    )
    parts = [
        state,
        where,
        f"Bf:{max(model.blocks - model.planned, 0)},{model.rx_size - len(model._rx)}",
    ]
    parts.append(f"FS:{model.rate / per if state == 'Run' else 0:.0f},0")
    if work != model.told_shift or model.reports % 10 == 0:
        model.told_shift = work
        parts.append(f"WCO:{said(work)}")
    model.reports += 1
    return f"<{'|'.join(parts)}>\r\n"
