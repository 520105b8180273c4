"""Random programs of drilling cycles."""

from __future__ import annotations

import random

from tests.linuxcnc.drawn_words import PLANES, SYSTEMS, line, number, some


def cycles(rng: random.Random, blocks: int) -> list[str]:
    state = {"inch": False}

    def size(low, high):
        return round(rng.uniform(low, high) / (20 if state["inch"] else 1), 2)

    def holes(across, depth, factor):
        """A start, a cycle, more holes, its end."""
        level = size(5, 20)
        lines = [
            line(
                rng,
                "G90 G0",
                depth + number(rng, level * factor[depth]),
                across[0] + number(rng, size(-20, 20)),
            )
        ]
        incremental = rng.random() < 0.35
        codes = ("G73", "G81", "G81", "G82", "G83", "G85", "G86", "G89")
        # LinuxCNC taps wrongly along X and Y
        code = rng.choice((*codes, "G84", "G74") if depth == "Z" else codes)
        if code == "G74":
            lines.append("M4")
        lines.append(first(across, depth, factor, code, incremental, level))
        for _ in range(rng.randint(0, 4)):
            lines.append(another(across, code, incremental))
        if code == "G74":
            lines.append("M3")
        lines.append(line(rng, rng.choice(("G80", "G0", "G80 G0")), "G90"))
        return lines

    def first(across, depth, factor, code, incremental, level):
        clear = size(-3, 7) if rng.random() < 0.8 else level + size(0, 5)
        bottom = clear - size(1, 9)
        values = (clear - level, bottom - clear) if incremental else (clear, bottom)
        r, z = (round(value, 2) for value in values)
        # R is a radius in G7, too
        words = [code, "G91" if incremental else "G90", "R" + number(rng, r)]
        words += [depth + number(rng, z * factor[depth])]
        words += [letter + number(rng, size(-9, 9)) for letter in some(rng, across, 1)]
        words += [rng.choice(("G98", "G99"))] if rng.random() < 0.6 else []
        if code in ("G73", "G83"):
            words.append("Q" + number(rng, max(0.04, size(1, 6))))
        if code in ("G82", "G86", "G89") or (code in ("G84", "G74") and rng.random() < 0.5):
            words.append("P" + rng.choice(("0", ".5", "1")))
        words += [f"L{rng.randint(1, 3)}"] if rng.random() < 0.2 and code != "G74" else []
        words += [f"F{rng.randint(50, 300)}"] if rng.random() < 0.3 else []
        return line(rng, *words)

    def another(across, code, incremental):
        choice = rng.random()
        if choice < 0.1:
            return rng.choice(("M8", "F200", "G4 P.1", "(next)", "S200", ""))
        words = [letter + number(rng, size(-9, 9)) for letter in some(rng, across, 1)]
        words += [rng.choice(("G98", "G99"))] if rng.random() < 0.2 else []
        words += (
            ["Q" + number(rng, max(0.04, size(1, 6)))]
            if code in ("G73", "G83") and rng.random() < 0.2
            else []
        )
        words += [f"L{rng.randint(1, 3)}"] if rng.random() < 0.15 and code != "G74" else []
        words += [code] if rng.random() < 0.1 and code in ("G81", "G85") else []
        words += [rng.choice(SYSTEMS)] if rng.random() < 0.1 and not incremental else []
        return line(rng, *words)

    lines = ["S100 M3 F100"]
    while len(lines) < blocks:
        if rng.random() < 0.2:
            state["inch"] = not state["inch"]
            lines.append("G20 F10" if state["inch"] else "G21 F100")
        diameter = rng.random() < 0.2
        plane = rng.choice(("G17", "G17", "G18", "G19"))
        lines.append(line(rng, plane, "G7" if diameter else "G8"))
        first_letter, second_letter, depth = PLANES[plane]
        factor = {"X": 2 if diameter else 1, "Y": 1, "Z": 1}
        lines += holes(first_letter + second_letter, depth, factor)
    return lines
