"""LinuxCNC programs and expressions drawn by chance: the motions and values of LinuxCNC's own
interpreter."""

from __future__ import annotations

import random

import pytest

from postproc.errors import ProgramError
from postproc.nc.expand import Limits
from tests.expand.linuxcnc_lines import Fine, by_oracle, check, run, texts
from tests.linuxcnc.test_against_linuxcnc import (
    CLOSE,
)

# Programs drawn by chance: blocks within blocks, loops that count, calls, jumps; all of it is
# defined in LinuxCNC.


class Chance:
    """Draws a program."""

    LABELS = ("{}", "<l{}>", "[{}]", "<L {}>", "{}.")
    MOVES = (
        "#32",
        "#33",
        "#1",
        "#2",
        "[#32*2]",
        "[#33-#1]",
        "#<a>",
        "#<_g>",
        "7",
        "[#5420+1]",
        "[#<_y>-2]",
        "-#2",
    )
    TESTS = (
        "#32 MOD 2 EQ 0",
        "#33 GT 3",
        "#1 LT 2",
        "#<a> GE 1 AND #32 LT 6",
        "#2",
        "1",
        "0",
        "#<_value_returned>",
    )
    SETS = (
        "#32=[#32+1]",
        "#33=[#32*2-#33 MOD 7]",
        "#<a>=[#<a>+1]",
        "#<_g>=[#<_g>-#<a>] #<a>=#<_g>",
        "#1=[#1+1]",
        "#2=[#1-#2]",
        "#[30+2]=[#33 MOD 5]",
        "#<a>=[#<a> MOD 11] #33=[#33 MOD 13]",
        "#32=[#32 MOD 9]",
        "#<_g>=[#<_g> MOD 17]",
    )

    def __init__(self, seed):
        self.draw, self.lines, self.subs, self.count = random.Random(seed), [], [], 0

    def program(self):
        self.lines += ["G0 X0 Y0 Z0", "#32=1 #33=2 #1=3", "#<a>=0 #<_g>=5"]
        behind = []
        for name in self.draw.sample(["500", "<first>", "501"], self.draw.randint(0, 3)):
            before, self.lines = self.lines, [f"o{name} sub", "#<a>=#1"]
            self.block(1, [], name)
            self.lines.append(f"o{name} endsub{self.draw.choice([' [#2+1]', '', ' [#<a>]'])}")
            body, self.lines = self.lines, before
            (behind if self.draw.random() < 0.4 else self.lines).extend(body)
            self.subs.append(name)
        self.block(0, [], "")
        self.lines += [f"o{name} call [1] [2]" for name in self.subs[:2]]
        self.block(0, [], "")
        return "\n".join([*self.lines, "M2", *behind]) + "\n"

    def label(self):
        self.count += 1
        return self.draw.choice(self.LABELS).format(self.count)

    def block(self, depth, loops, sub):
        for _ in range(self.draw.randint(1, 4)):
            kinds = [self.move, self.move, self.set]
            if depth < 4:
                kinds += [
                    self.branch,
                    self.loop,
                    self.loop,
                    self.repeat,
                    self.jump,
                    self.back,
                    self.call,
                ]
            self.draw.choice(kinds)(depth, loops, sub)

    def move(self, depth, loops, sub):
        words = [
            a + self.draw.choice(self.MOVES)
            for a in self.draw.sample("XYZ", self.draw.randint(1, 3))
        ]
        before = self.draw.choice(["", "", "N10 ", "G0 ", "G1 F100 ", "G91 ", "G90 ", "/"])
        self.lines.append(
            before
            + " ".join(words)
            + self.draw.choice(["", "", " (c #9)", " ; x", " #33=[#33 MOD 7+1]"])
        )

    def set(self, depth, loops, sub):
        self.lines.append(self.draw.choice(self.SETS))

    def test(self):
        return self.draw.choice(self.TESTS)

    def branch(self, depth, loops, sub):
        label = self.label()
        self.lines.append(f"o{label} if [{self.test()}]")
        self.block(depth + 1, loops, sub)
        for _ in range(self.draw.choice([0, 0, 1, 2])):
            self.lines.append(f"o{label} elseif [{self.test()}]")
            self.block(depth + 1, loops, sub)
        if self.draw.random() < 0.5:
            self.lines.append(f"o{label} else")
            self.block(depth + 1, loops, sub)
        self.lines.append(f"o{label} endif")

    def loop(self, depth, loops, sub):
        label = self.label()
        counter, most, do = (
            f"#{100 + self.count}",
            self.draw.randint(0, 4),
            self.draw.random() < 0.5,
        )
        test = f"o{label} while [{counter} LT {most}]"
        self.lines += [f"{counter}=0", f"o{label} do" if do else test, f"{counter}=[{counter}+1]"]
        self.block(depth + 1, [*loops, label], sub)
        self.lines.append(test if do else f"o{label} endwhile")

    def repeat(self, depth, loops, sub):
        label = self.label()
        self.lines.append(
            f"o{label} repeat [{self.draw.choice(['2', '#32 MOD 3', '1.5', '0', '3'])}]"
        )
        self.block(depth + 1, loops, sub)
        self.lines.append(f"o{label} endrepeat")

    def jump(self, depth, loops, sub):
        if loops:
            self.within(f"o{self.draw.choice(loops)} {self.draw.choice(['break', 'continue'])}")

    def back(self, depth, loops, sub):
        if sub:
            self.within(f"o{sub} return{self.draw.choice(['', ' [#1+#32]'])}")

    def within(self, line):
        label = self.label()
        self.lines += [f"o{label} if [{self.test()}]", line, f"o{label} endif"]

    def call(self, depth, loops, sub):
        earlier = self.subs[: self.subs.index(sub)] if sub in self.subs else self.subs
        if earlier:
            values = [
                f"[{v}]"
                for v in self.draw.choices(
                    ["#1", "#32", "3", "#<a>", "#33-1"], k=self.draw.randint(0, 3)
                )
            ]
            self.lines.append(f"o{self.draw.choice(earlier)} call {' '.join(values)}")
            self.lines.append("#33=[#<_value>+#<_value_returned>]")


def test_programs_drawn_by_chance():
    programs = [(text, {}) for text in (Chance(seed).program() for seed in range(80)) if ends(text)]
    assert len(programs) >= 70
    for (text, kwargs), expected in zip(programs, by_oracle(programs), strict=True):
        check(text, kwargs, expected)


def ends(text):
    """Whether a program comes to its end, and not beyond a kilometre; LinuxCNC would be waited for
    in vain."""
    try:
        run(text, limits=Limits(steps=2000, depth=20))
    except ProgramError as error:
        assert "lines were executed" in error.message or "beyond 1e+06 mm" in error.message, error
        return False
    return True


def drawn_expression(draw, depth=0):
    if depth > 1 or draw.random() < 0.2:
        return draw.choice(
            [f"{draw.uniform(-9, 9):.3f}", str(draw.randint(0, 12)), "#1", "#2", "#<a>"]
        )
    inner = lambda: drawn_expression(draw, depth + 1)
    function = draw.choice(["SIN", "COS", "ABS", "FIX", "FUP", "ROUND", "", "", "", "-"])
    if draw.random() < 0.1:
        return f"ATAN[{inner()}]/[{inner()}]"
    signs = draw.choices(
        ["+", "-", "*", " EQ ", " NE ", " GT ", " LT ", " GE ", " LE ", " AND ", " OR ", " XOR "],
        k=2,
    )
    return f"{function}[{inner()}{signs[0]}{inner()}{signs[1]}{inner()} MOD {draw.randint(2, 9)}]"


def test_expressions_drawn_by_chance():
    draw = random.Random(1)
    drawn = [e for e in (drawn_expression(draw) for _ in range(600)) if len(e) < 200]
    assert len(drawn) > 300
    moves = [f"X[[{expression}] MOD 1000]" for expression in drawn]
    text = "\n".join(["#1=1.25 #2=-3 #<a>=7", "G0 X5000", *moves, "M2"])
    [expected] = by_oracle([(text, {})])
    assert isinstance(expected, list), expected
    found = [float(line[1:]) for line in texts(text, tracker=Fine)[1:-1]]
    assert found == pytest.approx([m.end[0] for m in expected][1:], abs=CLOSE)
