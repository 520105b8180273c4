"""Snippets that move, and that shift the coordinates."""

from __future__ import annotations

import math

from fuzz.words import (
    CENTRE,
    COMMENTS,
    PLANES,
    Words,
)


class Motions(Words):
    """Lines, arcs, modes, offsets, frames, cutter compensation."""

    def straight(self) -> None:
        code = self.one("G0", "G1", "G1", "G1", "")
        if self.printer and not code:
            code = "G1"
        feed = (
            ["F" + self.one("100", "250.", "0.5", "3.25")]
            if code == "G1" and self.often(0.8)
            else []
        )
        self.add(
            self.g(code) if code else "",
            *self.coordinates(),
            *feed,
            self.one("", "", "", "", "M3", "M8", "M5", "M9", "S100"),
        )

    def small(self) -> None:
        """Increments and tiny moves."""
        if self.system_a:
            self.add(
                "G1",
                *[
                    f"{u}{self.num(self.rng.uniform(-0.01, 0.01), 4)}"
                    for u in "UW"
                    if self.often(0.7)
                ],
                "F50",
            )
            return
        size = self.one(0.0004, 0.003, 0.05, 2.0, 0.0)
        self.add("G91", self.g("G1"), *self.coordinates(size=size), "F200")
        for _ in range(self.rng.randint(0, 3)):
            self.add("G1" if self.printer else "", *self.coordinates(size=size))
        if self.often(0.8):
            self.add("G90")

    def increments(self) -> None:
        words = []
        for axis, letter in (("X", "U"), ("Z", "W")):
            roll = self.rng.random()
            if roll < 0.5:
                words.append(self.word(letter, self.rng.uniform(-6, 6)))
            elif roll < 0.8:
                words.append(self.word(axis, self.goal(axis) * self.factor(axis)))
        self.add(self.one("", "G1", "G0"), *words)

    def arc(self) -> None:
        """Onto a known place, then an arc or circle from there."""
        letters = PLANES[self.plane]
        if set(letters) - set(self.ranges):
            self.plane = "G18"
            self.add("G18")
            letters = PLANES[self.plane]
        low, high = zip(*(self.ranges[a] for a in letters), strict=True)
        room = min(h - lo for lo, h in zip(low, high, strict=True)) / 2
        radius = 10 ** self.rng.uniform(-2.0 if self.often(0.2) else 0.0, math.log10(0.8 * room))
        middle = [
            self.rng.uniform(lo + radius, h - radius) for lo, h in zip(low, high, strict=True)
        ]
        begin = self.one(0, 90, 180, 270) if self.often(0.4) else self.rng.uniform(0, 360)
        sweep = (
            360.0
            if self.often(0.2)
            else self.one(90, 180, 270, 0.5, 359.9)
            if self.often(0.4)
            else self.rng.uniform(1, 359)
        )
        if self.often(0.5):
            sweep = -sweep
        digits = self.one(3, 4, 5)
        unit = [self.factor(a) for a in letters]
        spot = [
            [
                round((c + radius * f(math.radians(turn))) * u, digits)
                for c, f, u in zip(middle, (math.cos, math.sin), unit, strict=True)
            ]
            for turn in (begin, begin + sweep)
        ]
        first = [a + self.num(v, digits) for a, v in zip(letters, spot[0], strict=True)]
        self.add(self.absolute(), self.g(self.one("G0", "G1")), *first, self.one("", "F80"))
        for _ in range(self.one(1, 1, 1, 2)):
            code = "G3" if sweep > 0 else "G2"
            end = (
                [a + self.num(v, digits) for a, v in zip(letters, spot[1], strict=True)]
                if abs(sweep) < 360 or self.often(0.4)
                else []
            )
            arm = [(c - s / u) / self.scale for c, s, u in zip(middle, spot[0], unit, strict=True)]
            other = [a for a in self.ranges if a not in letters and self.often(0.3)]
            words = end + self.coordinates(other)
            whole = abs(sweep) >= 360
            if not whole and abs(abs(sweep) - 180) > 1 and self.often(0.4):
                r = radius / self.scale * (1 if abs(sweep) < 180 else -1)
                words.append(f"CR={r:.{digits + 1}f}" if self.siemens else f"R{r:.{digits + 1}f}")
            elif self.din:
                self.add(
                    *[
                        CENTRE[a] + self.num(c * u, digits)
                        for a, c, u in zip(letters, middle, unit, strict=True)
                    ]
                )
            else:
                words += [
                    CENTRE[a] + self.num(v, digits) for a, v in zip(letters, arm, strict=True)
                ]
            if self.often(0.15 if self.turns else self.wild):
                count = (
                    self.one(1, 2, 3, 0, 20)  # a turn over a bent map takes 0.06 s
                    if not self.often(self.wild)
                    else self.one(100000, 999999999, 10**17)
                )
                words.append(f"TURN={count}" if self.siemens else f"P{count}")
            feed = self.one("", "F60", "F5")
            self.add(self.g(code), *words, feed)
            spot = [spot[1], spot[0]]
            begin, sweep = begin + sweep, -sweep
        if self.printer and self.lines and self.often(0.5):
            self.lines[-1] += " E1.5"

    def modes(self) -> None:
        codes = []
        if self.often(0.3) and not self.system_a:
            codes.append(self.one("G91", "G90", "G90"))
        if self.often(0.25):
            inch = self.often(0.5)
            self.scale = 25.4 if inch else 1.0
            if self.siemens or self.din:
                codes.append(
                    self.one("G70", "G700")[: 4 if self.siemens else 3]
                    if inch
                    else self.one("G71", "G710")[: 4 if self.siemens else 3]
                )
            else:
                codes.append("G20" if inch else "G21")
        if self.often(0.3) and not self.lathe:
            self.plane = self.rng.choice(list(PLANES))
            codes.append(self.plane)
        if self.often(0.3):
            codes.append(
                self.one("G94", "G93", "G95") if not self.system_a else self.one("G98", "G99")
            )
        if self.often(0.15):
            codes.append("DIAMON" if self.siemens else self.one("G7", "G8"))
        if self.often(0.1):
            codes.append("DIAMOF" if self.siemens else self.one("G91.1", "G91.1", "G90.1"))
        if self.often(0.1):
            codes.append(self.one("G98", "G99"))
        self.rng.shuffle(codes)
        if codes:
            self.add(*codes, "F20" if "G93" in codes else "")

    def stops(self) -> None:
        self.add(self.one("G61", "G64", "G61.1", "G60", "G602", "G64 P0.01", "G63"))
        if self.often(0.5):
            self.add(self.one("G9", "G9", "G60"), "G1", *self.coordinates(), "F100")

    def quiet(self) -> None:
        comment = self.rng.choice(COMMENTS)
        self.lines.append(
            self.one(
                "M3 S500",
                "M5",
                "M8",
                "M9",
                "T1 M6",
                "T2",
                "T1",
                "T0101",
                "",
                " ",
                f"({comment})",
                "M1",
                "M0",
                "S200",
                "F77",
                "G40",
                "G80",
                "G49",
                "G94",
                "D1",
                "D0",
                "M6 T2",
            )
            if not self.siemens
            else self.one(
                "M3 S500",
                f"; {comment}",
                f'MSG("{comment}")',
                "T1 D1",
                "D0",
                "D2",
                "G64",
                "S1=300",
                "SPOS=0",
                'T="A"',
                "",
                "FFWON",
            )
        )

    def offset(self) -> None:
        self.add(
            self.one(
                "G54",
                "G55",
                "G56",
                "G57",
                "G59",
                "G59.1",
                "G59.3",
                "G54.1 P1",
                "G54.1 P2",
                "G54 P1",
                "G154 P1",
                "G110",
                "G500",
                "G505",
                "G54",
            ),
            *(self.coordinates() if self.often(0.3) else []),
        )

    def frame(self) -> None:
        shift = self.coordinates(size=self.one(0.001, 3.0, 20.0, 0.0))
        if self.siemens or (self.din and self.often(0.6)):
            self.add(
                (
                    self.one("TRANS", "TRANS", "ATRANS", "TRANS", "G58", "G53", "SUPA")
                    if self.siemens
                    else self.one("G54", "G53")
                ),
                *(shift if self.often(0.85) else []),
            )
            if self.often(0.5) and not self.din:
                self.add("G91", *self.coordinates(size=1.0))
                self.add("G90")
            return
        set_here = "G50" if self.system_a else "G92"
        kind = self.rng.randint(0, 13)
        if kind <= 1:
            self.add("G52", *shift)
        elif kind <= 4:
            self.add(set_here, *self.coordinates())
        elif kind == 5:
            self.add(self.one("G92.1", "G92.2", "G92.3", "G52 X0 Z0", "G50.3"))
        elif kind <= 7:
            self.add(
                "G10",
                self.one("L2", "L2", "L20", "L20", "L1", "L10", "L11", "L50", "L3", ""),
                self.one("P1", "P0", "P2", "P3", "P6", "P9", "P10", "P1e18", "P99999999"),
                *shift,
                self.one("", "", "", "R1"),
            )
        elif kind <= 9:
            self.add(
                self.one("G43", "G43", "G44", "G43.2"),
                self.one("H1", "H2", "H0", "", "H7"),
                *(self.coordinates() if self.often(0.4) else []),
            )
        elif kind == 10:
            self.add("G43.1", *shift)
        elif kind == 11:
            self.add("G49", *(self.coordinates() if self.often(0.3) else []))
        elif kind == 12:
            self.add(self.one("G28.1", "G30.1", "G10.9"))
        else:
            self.add("G92", self.one("S1000", "E0", "X0", "X0 Y0 Z0"))
        if self.often(0.5):
            self.add(self.one("G0", "G1 F100"), *self.coordinates())

    def away(self) -> None:
        kind = self.rng.randint(0, 4)
        if kind <= 1:
            self.add(
                self.absolute(),
                self.one("G53", "G53", "SUPA" if self.siemens else "G53", "G153"),
                self.one("G0", "G1"),
                *self.coordinates(),
                "F100",
            )
        elif kind == 2:
            self.add(
                self.one("G28", "G30", "G74" if self.siemens else "G28"),
                *(self.coordinates() if self.often(0.5) else []),
            )
        elif kind == 3:
            self.add(
                self.one("G28 U0", "G28 W0", "G28 U0 W0")
                if self.lathe
                else self.one("G91 G28 Z0", "G28 X0 Y0", "G28 X Y", "G28")
            )
            if not self.lathe:
                self.add("G90")
        if self.often(0.85):
            self.add(self.absolute(), "G0", *self.coordinates(self.ranges))

    def beside(self) -> None:
        """Cutter radius compensation."""
        self.add(
            self.one("G41", "G42"),
            self.one("D1", "", "D2", "G1"),
            *self.coordinates(list(PLANES[self.plane])[:2] if not self.lathe else None),
            "F100",
        )
        for _ in range(self.rng.randint(1, 3)):
            self.one(self.straight, self.straight, self.arc)()
        if self.often(0.9):
            self.add("G40", self.one("G1", "G0"), *self.coordinates())

    def dwell(self) -> None:
        self.add("G4", self.one("P0.5", "X1", "F2", "S3", "U1.", "P500", "P0"))
