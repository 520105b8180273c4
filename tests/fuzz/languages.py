"""Snippets that a dialect alone has: its own words, its macros, and text that is wrong."""

from __future__ import annotations

from fuzz.words import (
    EXTREMES,
    TEXT,
    Words,
)


class Languages(Words):
    """Words of one control, macros, junk."""

    def own(self) -> None:
        """What only a Fagor or an Okuma writes: offsets and lengths by their names, holes with
        their own words, remarks."""
        low, high = self.ranges["Z"]
        level, bottom = sorted(
            (round(self.rng.uniform(low, high), 2) for _ in range(2)), reverse=True
        )
        at = self.coordinates("XY")
        if self.dialect == "fagor":
            lines = (
                ["G0 #MCS", "Z" + self.num(high)],
                ["#MCS", *at, "F90"],
                ["G0 Z" + self.num(high), "D1"],
                ["T1 D1"],
                ["D2"],
                ['(MSG "PART")'],
                ["#HSC ON [E0.01]"],
                ["G5"],
                ["G7"],
                ["G51 A5 E0.02"],
                ["P1=5"],
                ["(RPT N10,N20)"],
                ["G36 R2"],
                ["#RTCP ON"],
                [self.one("G98", "G99"), "G81", *at, f"Z{level} I{bottom} K1 F100"],
                [
                    "G98 G83",
                    *at,
                    (
                        f"Z{level} I-{self.num(self.rng.uniform(0.5, 9), 2)}"
                        f" J{self.rng.randint(0, 5)} F100"
                    ),
                ],
                ["G99 G85", *at, f"Z{level} I{bottom} F100"],
            )
        else:
            lines = (
                ["G15 H1"],
                ["G15 H2"],
                ["G56 H1"],
                ["G53"],
                [f"G71 Z{high}"],
                ["CALL OO88 PX=0"],
                ["VC1=5"],
                ["NLOW", "G1 X=VC1+2", "Z=-VC1/2", "F90"],
                ["IF [VC1 GT 3] NLOW"],
                ["CALL O2 Q2 PX=VC1"],
                ["MODIN O2"],
                ["RTS"],
                ["O2"],
                ["NOEX VC2=1"],
                ["G30 P1"],
                ["G0 X9999 Y9999"],
                ["G0 Z400"],
                ["M130"],
                ["G56 HA"],
                ["G81", *at, f"Z{bottom} R{level} F100", self.one("M52", "M53", "M54", "")],
                [
                    "G83",
                    *at,
                    f"Z{bottom} R{level} Q{self.num(self.rng.uniform(0.2, 9), 2)} F100 M53",
                ],
                [
                    "G73",
                    *at,
                    f"Z{bottom} R{level} I{self.num(self.rng.uniform(0.2, 9), 2)} J20 F100 M54",
                ],
                ["NCYL G82", *at, f"Z{bottom} R{level} P1 F100"],
            )
        chosen = self.rng.choice(lines)
        self.add(*chosen)
        if chosen[0][-3:-1] == "G8" or chosen[0] in ("G81", "G83", "G73", "NCYL G82"):
            for _ in range(self.rng.randint(0, 2)):
                self.add(*self.coordinates("XY"))
            self.add("G80")

    def macro(self) -> None:
        """Variables, loops and calls: refused as they are, written out under --expand."""
        self.number += 1
        n = self.number
        step = self.one("1", "2.5", "0.1")
        if self.siemens:
            body = [f"G1 X=R{1} Y=R2*2 F100"]
            self.lines += self.one(
                [f"R1={step}", "R2=SIN(30)*10", *body],
                ["R1=0", "WHILE R1<3", *body, f"R1=R1+{step}", "ENDWHILE"],
                ["FOR R1=1 TO 4", *body, "ENDFOR"],
                ["R1=0", f"LB{n}:", *body, "R1=R1+1", f"IF R1<3 GOTOB LB{n}"],
                ["R1=5", "IF R1==5", *body, "ELSE", "G0 X0", "ENDIF"],
                ["DEF REAL LEN=12.5", "G1 X=LEN F50"],
                [f"LA{n}:", "G91 G1 X1 F100", "G90", f"REPEAT LA{n} P=2"],
                ["LOOP", "G91 G1 X.1 F9", "ENDLOOP"],
                ["R1=0", "REPEAT", *body, "R1=R1+1", "UNTIL R1>=2"],
                [f"GOTOF LZ{n}", "G1 X999999", f"LZ{n}:"],
                ["R1=$AA_IW[X]", "G1 X=R1+1 F10"], ["G1 X=" + "(" * 30 + "1" + ")" * 30 + " F10"],
                ["CASE 2 OF 1 GOTOF A1 2 GOTOF A2 DEFAULT GOTOF A2", "A1:", "A2:"],
            )  # fmt: skip
        elif self.fanuc:
            body = ["G1 X[#1*2] F100"] if self.lathe else ["G1 X#1 Y[#1+1] F100"]
            sub = [f"O{n}0", "G1 X[5+#24]" if self.often(0.5) else "G1 X5. F100", "M99"]
            which = self.rng.randint(0, 7)
            if which == 0:
                self.lines += [f"#1={step}", *body]
            elif which == 1:
                self.lines += ["#1=0", "WHILE [#1 LT 3] DO1", *body, f"#1=#1+{step}", "END1"]
            elif which == 2:
                self.lines += ["#1=0", f"N{n}0", *body, "#1=#1+1", f"IF [#1 LT 2] GOTO {n}0"]
            elif which == 3:
                self.lines += [
                    f"M98 P{n}0" + self.one("", " L2", "L999999" if self.often(self.wild) else "")
                ]
                self.tail += sub
            elif which == 4:
                self.lines += [f"G65 P{n}0 X{step} A1"]
                self.tail += sub
            elif which == 5:
                self.lines += [
                    "IF [#1 EQ #0] THEN #2=5",
                    "#3=ATAN[1]/[2]+SQRT[ABS[-4]]",
                    "G1 X#3 F100",
                ]
            elif which == 6:
                self.lines += ["#1=" + "[" * 20 + "1" + "]" * 20, *body]
            else:
                self.lines += (
                    ["#5=#5041", "G0 X[#5+1]", "WHILE[1 EQ 1]DO1", "G91G1X.1F1", "END1"]
                    if self.often(0.3)
                    else ["#5=#5041", "G0 X[#5+1]"]
                )
        else:
            body = ["G1 X#1 Y[#1 * 2] F100"]
            self.lines += self.one(
                [f"#1={step}", *body],
                ["#1=0", f"o{n} while [#1 LT 3]", *body, f"#1=[#1+{step}]", f"o{n} endwhile"],
                [f"o{n} sub", "G1 X[#1] F100", f"o{n} endsub", f"o{n} call [5] [6]"],
                [f"o{n} repeat [3]", "G91 G1 X0.5 F50", f"o{n} endrepeat", "G90"],
                [f"o{n} if [#5420 GT 5]", *body, f"o{n} else", "G0 X1", f"o{n} endif"],
                ["#<len>=12.5", "G1 X#<len> F50"],
                ["#1=0", f"o{n} do", *body, "#1=[#1+1]", f"o{n} while [#1 LT 2]"],
                [f"o{n} while [1]", "G91 G1 X.001 F50", f"o{n} endwhile"],
                ["G1 X[SIN[30]*10] Y[2**3 MOD 5] F10"],
                ["G1 X" + "[" * 30 + "1" + "]" * 30 + " F10"],
                ["#1=3 #1=4 G1 X#1 F10"],
                [f"o<a{n}> sub", f"o<a{n}> endsub", f"o<a{n}> call"],
                ["#5221=3", "G1 X0 F10"],
                ["G0 X[#5420+1] Y[#5421]"],
            )

    def junk(self) -> None:
        roll = self.rng.random()
        if roll > 1 - 6 * self.wild:
            self.lines.append(
                self.one(
                    "G1 X1 X2",
                    "G1 G0 X5",
                    "X Y",
                    "G999",
                    "M999",
                    "G5 X1",
                    "G2 X1 Y1",
                    "G2 I0 J0",
                    "G2 X5 R0.001",
                    "Q5",
                    "E5",
                    "A5",
                    "G1 X--5",
                    "G1 X1.2.3",
                    "GCOMP",
                    "G1.5 X2",
                    "X1O",
                    "G1X 1 0 Y\t5",
                    "N5",
                    "O5",
                    "/",
                    "//G1X1",
                    "G3 P2 I5",
                    "$H",
                    ":1234",
                    "G1 X5,R2",
                    "G1X5 F0",
                    "G1 X5 F-1",
                    "G53 X5",
                    "G80 X5",
                    "G28 X5 G1 Y5",
                    "G92 G1 X5",
                    "G10",
                    "G41",
                    "G90 G91 X1",
                    "G20 G21 X1",
                    "M2",
                    "%",
                )
            )

    def spoil(self) -> None:
        """Something into a line that was right."""
        if not self.lines:
            return
        i = self.rng.randrange(len(self.lines))
        line = self.lines[i]
        at = self.rng.randint(0, len(line))
        self.lines[i] = (
            line[:at]
            + self.rng.choice((*TEXT, *EXTREMES, "G1", "X5"))
            + line[at + self.one(0, 0, 1) :]
        )
