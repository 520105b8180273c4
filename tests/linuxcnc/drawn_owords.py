"""Random programs of O-words: subs, loops, conditions and expressions, none of which can fail."""

from __future__ import annotations

import random

from tests.linuxcnc.drawn_words import LONGEST, some


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
