"""Random programs of frames: every way to move a zero, and motions between."""

from __future__ import annotations

import random

from tests.linuxcnc.drawn_words import ROTARY, SYSTEMS, TOOLS, line, number, some


def frames(rng: random.Random, blocks: int) -> list[str]:
    modes = {"inch": False, "incremental": False, "table written": False}

    def size(most=50):
        return round(
            rng.uniform(-most, most) / (20 if modes["inch"] else 1), 1 if rng.random() < 0.5 else 2
        )

    def words(letters="XYZ", least=1):
        chosen = some(rng, letters, least)
        if rng.random() < 0.1:
            chosen.append(rng.choice(ROTARY))
        return [letter + number(rng, size()) for letter in chosen]

    def motion():
        code = rng.choice(("", "", "G0", "G1"))
        return line(rng, code, *words())

    def circle():
        return line(
            rng, rng.choice(("G2", "G3")), "G17", rng.choice("IJ") + number(rng, size() or 1.0)
        )

    def mode():
        choice = rng.randrange(4)
        if choice == 0:
            # G49 first: LinuxCNC forgets to convert a tool length in force
            modes["inch"] = not modes["inch"]
            return "G49\n" + line(rng, "G20" if modes["inch"] else "G21")
        if choice == 1:
            return line(rng, rng.choice(("G7", "G8")))
        modes["incremental"] = not modes["incremental"]
        return line(rng, "G91" if modes["incremental"] else "G90")

    def system():
        return line(rng, rng.choice(SYSTEMS), *(words() if rng.random() < 0.5 else ()))

    def local():
        return line(rng, rng.choice(("G92", "G92", "G52")), *words())

    def suspend():
        return line(
            rng, rng.choice(("G92.1", "G92.2", "G92.3")), *(words() if rng.random() < 0.3 else ())
        )

    def set_system():
        return line(
            rng, "G10", rng.choice(("L2", "L20")), f"P{rng.choice((0, 1, 1, 2, 3, 9))}", *words()
        )

    def set_tool():
        modes["table written"] = True
        return line(
            rng, "G10", rng.choice(("L1", "L10", "L11")), f"P{rng.choice(tuple(TOOLS))}", *words()
        )

    def length():
        choice = rng.randrange(6)
        if choice == 0:
            return line(rng, "G43.1", *words("XZ"))
        if choice == 1:
            return line(rng, "G43.2", f"H{rng.choice(tuple(TOOLS))}")
        if choice == 2:
            return line(rng, "G49", *(words() if rng.random() < 0.3 else ()))
        if choice == 3:
            return line(rng, "G43", rng.choice(("", "H0")))
        return line(
            rng, "G43", f"H{rng.choice(tuple(TOOLS))}", *(words() if rng.random() < 0.3 else ())
        )

    def change():
        """A motion first: the oracle overlooks at M6 what was changed since the last one, and
        forgets G10 L1."""
        tool = f"T{rng.choice((0, 1, 2, 3))}"
        if modes["table written"] or rng.random() < 0.3:
            return tool
        return "\n".join((line(rng, rng.choice(("G0", "G1")), *words()), line(rng, tool, "M6")))

    def machine():
        modes["incremental"] = False
        return line(rng, "G53 G90", rng.choice(("G0", "G1")), *words())

    def reference():
        if rng.random() < 0.3:
            return line(rng, rng.choice(("G28.1", "G30.1")))
        return line(rng, rng.choice(("G28", "G30")), *(words() if rng.random() < 0.7 else ()))

    menu = (
        *(motion,) * 8,
        circle,
        *(mode,) * 3,
        *(system,) * 2,
        *(local,) * 3,
        *(suspend,) * 2,
        *(set_system,) * 3,
        set_tool,
        *(length,) * 3,
        change,
        machine,
        reference,
    )
    lines = ["G0 F500"]
    last = None
    while len(lines) < blocks:
        choice = rng.choice(menu)
        lines.append(choice())
        if choice is circle:  # axis words alone would be an arc
            lines.append(line(rng, rng.choice(("G0", "G1"))))
        last = choice
    if last is not motion:
        lines.append(line(rng, "G0 G90", *words("XYZ", 3)))
    return lines
