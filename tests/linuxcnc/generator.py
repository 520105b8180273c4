"""Random programs that LinuxCNC accepts, nearly always: `random_program(rng, kind)`.

Material for a differential fuzz. Numbers have few decimals, so that what is exact in millimetres
stays exact; functions that jump (FIX, MOD, comparisons) are given exact numbers only. Rotations are
left to the hand-written programs.
"""

from __future__ import annotations

import math
import random

TOOLS = {
    1: {"Z": 10.0, "D": 6.0},
    2: {"Z": 20.5, "X": 5.0, "D": 8.0},
    3: {"X": 1.0, "Y": -2.0, "Z": 3.25},
}
PARAMETERS = {
    5161: 5.0,
    5163: 60.0,
    5182: -7.5,
    5221: 10.0,
    5222: 20.0,
    5223: 30.0,
    5241: -100.0,
    5242: 50.5,
    5263: 7.0,
}
KEYWORDS = {"tools": TOOLS, "parameters": PARAMETERS}  # what these programs need beside their text
SYSTEMS = ("G54", "G55", "G56", "G59", "G59.1", "G59.3")
PLANES = {"G17": "XYZ", "G18": "ZXY", "G19": "YZX"}  # first, second, normal
CENTRE = {"X": "I", "Y": "J", "Z": "K"}
TRIPLES = ((3, 4, 5), (5, 12, 13), (8, 15, 17), (7, 24, 25), (20, 21, 29), (0, 1, 1))
ROTARY = "ABC"
LONGEST = 200  # of a line; LinuxCNC takes 252


def random_program(rng: random.Random, kind: str) -> str:
    """A program of 20 to 40 blocks or a little more; kind is one of KINDS."""
    return "\n".join((f"({kind})", *KINDS[kind](rng, rng.randint(20, 40)), "M2", ""))


def number(rng: random.Random, value: float) -> str:
    """One of the ways to write a number of at most four decimals."""
    text = f"{abs(value):.4f}".rstrip("0").rstrip(".") or "0"
    if text.startswith("0.") and rng.random() < 0.3:
        text = text[1:]
    elif "." not in text and rng.random() < 0.2:
        text += rng.choice((".", ".0"))
    elif rng.random() < 0.1:
        text = "0" + text
    negative = value < 0 and text.strip("0.")
    return ("-" if negative else "+" if rng.random() < 0.1 else "") + text


def line(rng: random.Random, *words: str) -> str:
    """The words, in any order, with some blanks and comments about them."""
    words = [word for word in words if word]
    rng.shuffle(words)
    text = rng.choice((" ", " ", " ", "", "  ")).join(words)
    if rng.random() < 0.1:
        text = text.lower()
    if rng.random() < 0.1:
        text += rng.choice((" (note)", " ; note"))
    return f"N{rng.randint(1, 999)} {text}" if rng.random() < 0.1 else text


def some(rng: random.Random, letters: str, least: int = 1) -> list[str]:
    return rng.sample(letters, rng.randint(least, len(letters)))


# -- frames: every way to move a zero, and motions between


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


# -- arcs


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


# -- drilling cycles


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


# -- O-words


class _Words:
    """A program with subs, loops, conditions and expressions, none of which can fail."""

    def __init__(self, rng: random.Random):
        self.rng = rng
        self.lines: list[str] = []
        self.label = 100
        self.subs: list[tuple[str, int]] = []  # name, number of arguments

    def new(self) -> str:
        self.label += 1
        return f"O{self.label}"

    def exact(self, names, depth=2) -> str:
        """A bracketed expression of whole and half numbers."""
        rng = self.rng
        choice = rng.random()
        if depth == 0 or choice < 0.35:
            return (
                rng.choice(names)
                if names and rng.random() < 0.7
                else rng.choice(("1", "2", "3", "0.5", "7", "-2", "4."))
            )
        a, b = self.exact(names, depth - 1), self.exact(names, depth - 1)
        if choice < 0.8:
            return f"[{a} {rng.choice('+-*')} {b}]"
        if choice < 0.88:
            return f"[{a} MOD {rng.choice((3, 5, 7))}]"
        if choice < 0.96:
            return f"{rng.choice(('ABS', 'FIX', 'FUP'))}[{a}]"
        return f"[{a} {rng.choice(('EQ', 'NE', 'GT', 'GE', 'LT', 'LE', 'AND', 'OR', 'XOR'))} {b}]"

    def smooth(self, names, depth=2) -> str:
        """An expression of which a small error stays small."""
        rng = self.rng
        choice = rng.random()
        if depth == 0 or choice < 0.3:
            return self.exact(names, 1)
        a, b = self.smooth(names, depth - 1), self.smooth(names, depth - 1)
        if choice < 0.6:
            return f"[{a} {rng.choice('+-*')} {b}]"
        if choice < 0.75:
            return f"[{a}/{rng.choice((2, 3, 8, 1.5))}]"
        if choice < 0.9:
            return f"{rng.choice(('SIN', 'COS', 'ABS'))}[{a}]"
        if choice < 0.95:
            return f"SQRT[[{a}*{a}]+1]"
        return f"ATAN[[{a}*{a}]+1]/[{b}]"

    def condition(self, names) -> str:
        operator = self.rng.choice(("EQ", "NE", "GT", "GE", "LT", "LE"))
        first = f"[{self.exact(names)} {operator} {self.exact(names, 1)}]"
        if self.rng.random() < 0.2:
            second = f"[{self.exact(names, 1)} GT {self.exact(names, 1)}]"
            return f"[{first} {self.rng.choice(('AND', 'OR', 'XOR'))} {second}]"
        return first

    def motion(self, names):
        code = self.rng.choice(("", "", "G0", "G1", "G90", "G91"))
        words = [letter + self.smooth(names) for letter in some(self.rng, "XYZ")]
        text = " ".join(word for word in (code, *words) if word)
        self.lines.append(text if len(text) < LONGEST else f"G0 X{self.exact(names)}")

    def assign(self, names):
        name = self.rng.choice(names)
        self.lines.append(f"{name}=[{self.exact(names)} MOD 10]")

    def call(self, names):
        if not self.subs:
            return self.motion(names)
        name, arguments = self.rng.choice(self.subs)
        given = self.rng.randint(0, arguments)
        self.lines.append(
            " ".join((name, "call", *(f"[{self.exact(names, 1)}]" for _ in range(given))))
        )

    def body(self, names, depth, blocks):
        menu = (self.motion, self.motion, self.motion, self.assign, self.call)
        for _ in range(blocks):
            if depth and self.rng.random() < 0.35:
                self.rng.choice((self.conditional, self.loop, self.loop, self.repeat, self.until))(
                    names, depth
                )
            else:
                self.rng.choice(menu)(names)

    def conditional(self, names, depth):
        label = self.new()
        self.lines.append(f"{label} if {self.condition(names)}")
        self.body(names, depth - 1, self.rng.randint(1, 2))
        if self.rng.random() < 0.4:
            self.lines.append(f"{label} elseif {self.condition(names)}")
            self.body(names, depth - 1, 1)
        if self.rng.random() < 0.5:
            self.lines.append(f"{label} else")
            self.body(names, depth - 1, 1)
        self.lines.append(f"{label} endif")

    def loop(self, names, depth):
        label, counter = self.new(), f"#<n{self.label}>"
        self.lines.append(f"{counter}=0")
        self.lines.append(f"{label} while [{counter} LT {self.rng.randint(0, 3)}]")
        self.lines.append(f"{counter}=[{counter}+1]")
        if self.rng.random() < 0.4:
            inner = self.new()
            self.lines.append(f"{inner} if {self.condition([*names, counter])}")
            self.lines.append(f"{label} {self.rng.choice(('break', 'continue'))}")
            self.lines.append(f"{inner} endif")
        self.body([*names], depth - 1, self.rng.randint(1, 2))
        self.lines.append(f"{label} endwhile")

    def until(self, names, depth):
        label, counter = self.new(), f"#<n{self.label}>"
        self.lines += [f"{counter}=0", f"{label} do", f"{counter}=[{counter}+1]"]
        self.body([*names], depth - 1, 1)
        self.lines.append(f"{label} while [{counter} LT {self.rng.randint(0, 3)}]")

    def repeat(self, names, depth):
        label = self.new()
        self.lines.append(f"{label} repeat [{self.rng.randint(0, 3)}]")
        self.body(names, depth - 1, self.rng.randint(1, 2))
        self.lines.append(f"{label} endrepeat")

    def sub(self):
        name = f"O<part{len(self.subs)}>" if self.rng.random() < 0.5 else self.new()
        arguments = self.rng.randint(0, 3)
        names = [f"#{i + 1}" for i in range(max(1, arguments))] + ["#<_height>"]
        self.lines.append(f"{name} sub")
        self.body(names, 1, self.rng.randint(1, 3))
        if self.rng.random() < 0.3:
            inner = self.new()
            self.lines.append(f"{inner} if {self.condition(names)}")
            self.lines.append(f"{name} return [{self.exact(names, 1)}]")
            self.lines.append(f"{inner} endif")
            self.motion(names)
        self.lines.append(f"{name} endsub")
        self.subs.append((name, arguments))


def owords(rng: random.Random, blocks: int) -> list[str]:
    made = _Words(rng)
    made.lines += ["#<_height>=3", "G0 F200"]
    for _ in range(rng.randint(1, 2)):
        made.sub()
    made.lines += ["#101=2 #102=5", "#<wide>=[#101+#102]", "G0"]
    names = ["#101", "#102", "#[100+1]", "#<wide>", "#<_height>"]
    while len(made.lines) < blocks:
        made.body(names, 2, 1)
    made.motion(names)
    return made.lines


KINDS = {"frames": frames, "cycles": cycles, "arcs": arcs, "owords": owords}
