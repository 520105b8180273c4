"""Random programs of arcs."""

from __future__ import annotations

import math
import random

from tests.linuxcnc.drawn_words import CENTRE, PLANES, ROTARY, TRIPLES, line, number, some


def arcs(rng: random.Random, blocks: int) -> list[str]:
    state = {
        "plane": "G17",
        "inch": False,
        "diameter": False,
        "incremental": False,
        "absolute centre": False,
    }
    place = {"X": 0.0, "Y": 0.0, "Z": 0.0}  # in the units in force; X a radius

    def shown(letter, value, incremental=None):
        """The word that takes an axis to `value`."""
        if state["incremental"] if incremental is None else incremental:
            value -= place[letter]
        return letter + number(rng, value * 2 if letter == "X" and state["diameter"] else value)

    def go(targets):
        words = [shown(letter, value) for letter, value in targets.items()]
        place.update(targets)
        return words

    def grid(value, step=None):
        return round(value, step if step is not None else 3 if state["inch"] else 2)

    def near(most):
        return grid(rng.uniform(-most, most) / (20 if state["inch"] else 1))

    def modes():
        words = []
        if rng.random() < 0.3:
            state["inch"] = not state["inch"]
        if rng.random() < 0.3:
            state["diameter"] = not state["diameter"]
        if rng.random() < 0.3:
            state["incremental"] = not state["incremental"]
        if rng.random() < 0.3:
            state["absolute centre"] = not state["absolute centre"]
        if rng.random() < 0.5:
            state["plane"] = rng.choice(tuple(PLANES))
        words += [
            "G20" if state["inch"] else "G21",
            "G7" if state["diameter"] else "G8",
            state["plane"],
        ]
        words += ["G90.1" if state["absolute centre"] else "G91.1"]
        for letter in place:
            place[letter] = near(20)
        start = [shown(letter, value, incremental=False) for letter, value in place.items()]
        return [
            line(rng, *words, "G90", rng.choice(("G0", "G1")), *start),
            line(rng, "G91" if state["incremental"] else "G90"),
        ]

    def turned(triple, scale):
        a, b = triple[0] * scale, triple[1] * scale
        a, b = rng.choice(((a, b), (b, a)))
        return rng.choice((-1, 1)) * a, rng.choice((-1, 1)) * b

    def extra(normal):
        """Words of an arc beside its plane: a helix, turns, a rotary axis."""
        words = go({normal: grid(place[normal] + near(5))}) if rng.random() < 0.3 else []
        words += [f"P{rng.randint(1, 4)}"] if rng.random() < 0.2 else []
        return words + (
            [rng.choice(ROTARY) + number(rng, rng.randint(-90, 90))] if rng.random() < 0.1 else []
        )

    def centre_arc():
        first, second, normal = PLANES[state["plane"]]
        triple = rng.choice(TRIPLES)
        scale = rng.choice((0.1, 0.5, 1, 2)) / (20 if state["inch"] else 1)
        v, w = turned(triple, scale), turned(triple, scale)
        middle = place[first] + v[0], place[second] + v[1]
        end = {first: grid(middle[0] + w[0], 4), second: grid(middle[1] + w[1], 4)}
        if not state["inch"] and rng.random() < 0.2:  # a spiral within the tolerance
            end[first] = grid(end[first] + rng.choice((-0.01, 0.01)), 4)
        offset = middle if state["absolute centre"] else v
        centre = [
            CENTRE[letter] + number(rng, value)
            for letter, value in zip((first, second), offset, strict=True)
            if state["absolute centre"] or abs(value) > 1e-9
        ]
        if rng.random() < 0.15:
            end = {}  # a full circle
        words = go(
            {
                letter: value
                for letter, value in end.items()
                if value != place[letter] or rng.random() < 0.5
            }
        )
        if end and not words:
            words = go(end)
        return [line(rng, rng.choice(("G2", "G3")), *words, *centre, *extra(normal))]

    def radius_arc():
        first, second, normal = PLANES[state["plane"]]
        a, b = near(15), near(15)
        half = math.hypot(a, b) / 2
        if half < 0.01:
            return []
        radius = grid(half * rng.choice((1.05, 1.5, 3, 20)) + (0.001 if state["inch"] else 0.01), 4)
        words = go({first: grid(place[first] + a, 4), second: grid(place[second] + b, 4)})
        radius = "R" + number(rng, rng.choice((-1, 1)) * radius)
        return [line(rng, rng.choice(("G2", "G3")), *words, radius, *extra(normal))]

    def straight():
        letters = some(rng, "XYZ")
        return [
            line(
                rng,
                rng.choice(("G0", "G1")),
                *go({i: grid(place[i] + near(10), 4) for i in letters}),
            )
        ]

    lines = ["F300", *modes()]
    while len(lines) < blocks:
        lines += rng.choice((centre_arc, centre_arc, centre_arc, radius_arc, straight, modes))()
    return lines
