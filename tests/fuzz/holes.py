"""Snippets of cycles: holes, threads, turned coordinates, keywords."""

from __future__ import annotations

from fuzz.words import (
    Words,
)


class Holes(Words):
    """Cycles, extrusion, Sinumerik's keywords and polynomials."""

    def holes(self) -> None:
        """A canned cycle with its holes; on a Sinumerik its own."""
        low, high = self.ranges["Z"]
        level, bottom = sorted(
            (self.rng.uniform(low, high), self.rng.uniform(low, high)), reverse=True
        )
        if self.siemens:
            name = self.one(
                "CYCLE81", "CYCLE82", "CYCLE83", "MCALL CYCLE81", "HOLES1", "CYCLE85", "CYCLE840"
            )
            self.add(
                f"{name}({self.num(high, 1)}, {self.num(level, 2)}, 1., {self.num(bottom, 2)})"
            )
            self.add(*self.coordinates("XY"))
            if "MCALL" in name:
                self.add("MCALL")
            return
        self.add(self.one("G0", "G0", "G1"), "Z" + self.num(high / self.scale, 2))
        if self.often(0.3) and not self.system_a:
            self.add("G91")
        code = self.one(
            "G81",
            "G81",
            "G82",
            "G83",
            "G73",
            "G85",
            "G86",
            "G89",
            "G84",
            "G74",
            "G87",
            "G88",
            "G76",
        )
        more = (
            [self.word("Q", self.rng.uniform(-0.5, 5) / self.scale)]
            if code in ("G83", "G73", "G87", "G76") or self.often(0.1)
            else []
        )
        if self.often(0.3):
            more.append(self.one("P0.5", "P1", "P500"))
        if self.often(0.2):
            more.append(
                self.one(
                    "L2", "L0", "K3", "K0", "L1", "L3", "L999999" if self.often(self.wild) else "L2"
                )
            )
        words = [
            f"Z{self.num(bottom / self.scale, 2)}",
            f"R{self.num(level / self.scale, 2)}",
            *more,
            "F100",
        ]
        self.rng.shuffle(words)
        self.add(
            *([] if self.system_a else [self.one("G98", "G99", "")]),
            code,
            *self.coordinates([a for a in self.ranges if a != "Z"]),
            *words,
        )
        for _ in range(self.rng.randint(0, 4)):
            self.add(
                *self.coordinates([a for a in self.ranges if a != "Z" and self.often(0.7)]),
                self.word("R", self.rng.uniform(low, high)) if self.often(0.1) else "",
                self.word("Z", self.rng.uniform(low, bottom)) if self.often(0.2) else "",
                self.one("", "", "", "L2", "G98", "G99", "L0"),
            )
            if self.often(0.05):
                self.add(
                    self.one(
                        "G20",
                        "G92 X5",
                        "G91",
                        "G55",
                        "G18",
                        "(HERE)",
                        "M9",
                        "G52 X1",
                        "T1 M6",
                        "G43 H1",
                    )
                )
        self.add(self.one("G80", "G80", "G80", "G0", "G1", ""))
        if self.often(0.8) and not self.system_a:
            self.add("G90")

    def thread(self) -> None:
        kind = self.rng.randint(0, 3)
        if kind <= 1:
            self.add(
                self.one("G33", "G32", "G33.1", "G34"),
                "Z" + self.num(self.goal("Z")),
                self.one("K1.5", "F2.", "K1", ""),
            )
        elif kind == 2:
            self.add(
                "G76",
                self.one(
                    "P1 Z-10 I-1 J0.2 R1.5 K1 Q29 H3 E0.5 L2",
                    "P010060 Q100 R0.1",
                    "X20. Z-30. P1000 Q300 F2.",
                ),
            )
        else:
            self.add(
                self.one(
                    "G92 X20. Z10. F1.5",
                    "G71 U1. R0.5",
                    "G71 P10 Q20 U0.5 W0.1 F0.2",
                    "G72 W1 R1",
                    "G70 P10 Q20",
                    "G75 R1.",
                    "G94 X10 Z5",
                    "G90 X10 Z5",
                )
            )

    def turned(self) -> None:
        begin, end = self.one(
            ("G68 X10 Y10 R30", "G69"),
            ("G68 X0 Y0 R-90.", "G69"),
            ("G51 X0 Y0 P2", "G50"),
            ("G51.1 X0", "G50.1 X0"),
            ("G16", "G15"),
            ("G10 L2 P1 R15", "G10 L2 P1 R0"),
            ("ROT RPL=30", "ROT"),
            ("MIRROR X0", "MIRROR"),
            ("SCALE X2 Y2", "SCALE"),
            ("AROT Z45", "TRANS"),
            ("ROT Z30", "ROT"),
        )
        self.add(begin)
        for _ in range(self.rng.randint(1, 3)):
            self.one(self.straight, self.arc, self.holes)()
        self.add(end)

    def extrude(self) -> None:
        kind = self.rng.randint(0, 9)
        if kind <= 5:
            self.add(
                "G1",
                *self.coordinates(),
                "E" + self.num(self.rng.uniform(-1, 30), 5),
                self.one("", "F1200"),
            )
        elif kind == 6:
            self.add(
                self.one("M82", "M83", "G92 E0", "G92 E0", "T1", "T0", "M204 P500", "M92 X80 Y80")
            )
        elif kind == 7:
            self.add("G1", "E" + self.num(self.rng.uniform(-3, 3), 3), "F2400")
        elif kind == 8:
            self.lines.append(
                self.one(
                    "M117 G1 is (done",
                    "M104 S200",
                    "M106 S255",
                    "G28 X Y",
                    "G28",
                    "G29",
                    "M400",
                    "M110 N5",
                    "M110",
                    "M203 X",
                    "G4 P5",
                    "G10",
                    "G11",
                    'M98 P"x"',
                )
            )
        else:
            self.add(self.one("G2", "G3"), *self.coordinates("XY"), "I5 J5 E3")

    def by_keyword(self) -> None:
        self.add(
            self.one(
                "DIAMON",
                "DIAMOF",
                "DIAM90",
                "G500",
                "CFC",
                "STOPRE",
                "CIP",
                "CT",
                "ROT",
                "TRANS X=5",
                "ATRANS Z-1",
                "LIMS=2000",
                "SOFT",
                "G1 X=IC(0.5) Y=AC(10) F=200",
                "G0 Z=IC(-1)",
                "G91 X=AC(5) Y1",
                "G90",
                "G111 X0 Y0",
                "G641 ADIS=0.5",
                "CYCLE832(0.01,1)",
                "G1 A=DC(90)",
                "G2 X=IC(10) Y=IC(0) CR=5",
                "G3 X20 Y20 I=AC(15) J=AC(15)",
                "G1 X1=5",
                "X = 5",
                "G4 F1",
                "RND=2",
                "CHF=1",
            ),
        )

    def polynomial(self) -> None:
        """POLY of a Sinumerik: ends with their coefficients, at times a denominator, and back to
        lines."""
        words = []
        for a in self.axes():
            more = ",".join(
                self.num(self.rng.uniform(-8, 8), 2) for _ in range(self.rng.randint(0, 4))
            )
            words.append(f"PO[{a}]=({self.num(self.goal(a))}{',' if more else ''}{more})")
        if self.often(0.2):
            words.append(
                f"PO[]=({self.num(self.rng.uniform(0.5, 3), 2)},{self.num(self.rng.uniform(-0.3, 0.3), 2)})"  # noqa: E501
            )
        if self.often(0.5):
            words.append(
                "PL=" + self.one("1", "2.5", "0.1", "10", "0" if self.often(self.wild) else "4")
            )
        self.add(self.one("POLY", "POLY", "G1 POLY"), *words, self.one("", "F200"))
        if self.often(0.4):
            self.add(*words)
        if self.often(0.8):
            self.add("G1", *self.coordinates(), "F100")
