"""Rectangular and circular pockets of Sinumerik: POCKET3 and POCKET4.

Siemens "SINUMERIK 840D/840Di/810D", Programming Guide Cycles, POCKET3 and POCKET4; the order of the
values as in MaTka's Sinumerik snippets (marketplace.visualstudio.com) and in
daviderobrtoalovisi/toleranza0, js/interpreter/siemens-pockets.js. In rapid traverse to the
retraction plane RTP, above the middle PA PO, to SDIS above the reference plane RFP.

- Roughing (_VARI 1): down to DP less the allowance FALD in equal depths, MID at most (0: at once),
  each cleared from the middle out up to the allowance FAL, ways MIDA apart at most (0: 0.8 of the
  tool's diameter). Into the depth at the middle: _VARI 01 in rapid traverse, 11 at the feed FFD, 21
  on a helix of radius RAD1, DP1 deeper in each turn.
- Finishing (_VARI 2): the wall, where FAL is not 0, down to FALD above the bottom, joined and left
  on a quarter circle; then the bottom, where FALD is not 0.
- _CDIR 0 climb milling, 1 up-cut (counter-clockwise and clockwise with M3), 2 as G2, 3 as G3.

Wall, bottom and sense are those of the manual. Which ways clear the inside it leaves open: here
rings, closer than MIDA where their corners are sharp. toleranza0 reads _VARI 11 as the helix: where
RAD1 and DP1 stand beside it, it is one here too, which lies in the same pocket. Refused: blanks
(AP1, AP2, AD), oscillating (_VARI 3x), measured from a corner (LENG, WID below 0), G91, other
planes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from postproc.nc.cycles.pocket_path import Piece, Point
from postproc.nc.cycles.rounded import Rounded, step_of
from postproc.nc.expand.siemens_values import Refusal, Value, numbers_by_name
from postproc.nc.expand.tracker import Tracker, number

_ENDS = "MID FAL FALD FFP1 FFD CDIR VARI MIDA AP1"
NAMES = {
    "POCKET3": f"RTP RFP SDIS DP LENG WID CRAD PA PO STA {_ENDS} AP2 AD RAD1 DP1",
    "POCKET4": f"RTP RFP SDIS DP PRAD PA PO {_ENDS} AD RAD1 DP1",
}
NEEDED = {
    "POCKET3": "RTP RFP DP LENG WID PA PO FFP1 VARI",
    "POCKET4": "RTP RFP DP PRAD PA PO FFP1 VARI",
}
WITH_M3 = {0: 1, 1: -1, 2: -1, 3: 1}  # the sense by _CDIR, counter-clockwise 1
MOST_DEPTHS = 1000
NEAR = 1e-6
JOIN_MM = 2.0  # radius of the quarter circles at the wall
WRITE_OUT = "let the CAM program write it out as G0, G1, G2 and G3"


@dataclass
class Pocket:
    """A call with its values. `sense`: 1 where the spindle turns by M3, -1 by M4."""

    name: str
    given: dict[str, float]
    sense: int = 1

    @classmethod
    def of(cls, name: str, values: Sequence[Value | None], sense: int) -> Pocket:
        """Raises Refusal for values that are none of a pocket that can be written out."""
        given = numbers_by_name(name, NAMES[name].split(), values, "correct the call")
        for word in NEEDED[name].split():
            if word not in given:
                raise Refusal(f"{name} without {word}", "write its value")
        pocket = cls(name, given, sense)
        pocket._check()
        return pocket

    def _get(self, word: str) -> float:
        return self.given.get(word, 0.0)

    def _check(self) -> None:
        g, kind = self.given, self.given["VARI"]
        odd = [w for w in ("AP1", "AP2", "AD") if self._get(w)]
        odd += [w for w in ("LENG", "WID") if g.get(w, 0.0) < 0]
        odd += [] if kind in (1, 2, 11, 12, 21, 22) else ["VARI"]
        if odd:
            raise Refusal(
                f"{self.name} with {odd[0]}={g[odd[0]]:g}, in a way that is not written out",
                WRITE_OUT,
            )
        if self._get("CDIR") not in WITH_M3:
            raise Refusal(f"CDIR of {self.name} is {g['CDIR']:g}", "0 to 3 are possible")
        if g["FFP1"] <= 0 or (kind != 1 and self._get("FFD") <= 0):
            raise Refusal(f"{self.name} without its feeds FFP1 and FFD", "write them, above 0")
        up = g["RTP"] >= g["RFP"] + self._get("SDIS") >= g["RFP"] > g["DP"] + self._get("FALD")
        if not up or min(self._get(w) for w in ("FAL", "FALD", "MID", "MIDA", "SDIS")) < 0:
            raise Refusal(
                f"the planes of {self.name} are not in order",
                "RTP, RFP + SDIS, RFP and DP + FALD in this order; no allowance below 0",
            )

    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        """The plain lines; feed: the F word in force. Raises Refusal."""
        plane, relative = tracker.code("plane"), tracker.code("distance") == 910
        if plane not in (-1, 170) or relative or tracker.is_diameter("X"):
            raise Refusal(
                f"{self.name} outside of G17, in G91 or in diameters",
                "write G17 G90 DIAMOF before it",
            )
        if tracker.code("cutter") in (410, 420):
            raise Refusal(f"{self.name} while G41 or G42 is in force", "write G40 before it")
        cut = _Cut(self, tracker, self._radius(tracker))
        if self.given["VARI"] % 10 == 1:
            cut.rough()
        else:
            cut.finish()
        motion = tracker.code("motion")
        last = [b"G%d" % (motion // 10)] if motion > 0 else []
        end = b" ".join([*last, *([b"F" + feed] if feed else [])])
        return [*cut.lines, *([end] if end else [])]

    def _radius(self, tracker: Tracker) -> float:
        """Of the tool, program's unit. Raises Refusal."""
        d = max(tracker.state.beside.offset, 1)  # a tool change names D1
        names = (f"D{d}", f"T{tracker.state.next_tool}D{d}")
        radius = next((r for n in names if (r := tracker.offset(n, "R"))), None)
        if not radius:
            raise Refusal(
                f"the tool's radius D{d} of {self.name} is not stated",
                f"say it in mm: --offset D{d}=Z0,R5",
            )
        return radius / 25.4 if tracker.inch else radius

    def shape(self) -> Rounded:
        """The wall."""
        g = self.given
        if self.name == "POCKET4":
            return Rounded(g["PRAD"], g["PRAD"], g["PRAD"])
        return Rounded(
            g["LENG"] / 2, g["WID"] / 2, min(self._get("CRAD"), g["LENG"] / 2, g["WID"] / 2)
        )


@dataclass
class _Cut:
    """Writes one pocket."""

    pocket: Pocket
    tracker: Tracker
    radius: float
    lines: list[bytes] = field(default_factory=list)

    def __post_init__(self) -> None:
        g, p = self.pocket.given, self.pocket
        self.rtp, self.rfp, self.dp = g["RTP"], g["RFP"], g["DP"]
        self.clear, self.fal, self.fald = (p._get(w) for w in ("SDIS", "FAL", "FALD"))
        self.plane = f" F{number(g['FFP1'], 3)}"
        self.down = f" F{number(p._get('FFD') or g['FFP1'], 3)}"
        self.ccw = WITH_M3[int(p._get("CDIR"))] * (self.pocket.sense if p._get("CDIR") < 2 else 1)
        turn = math.radians(p._get("STA"))
        self.cos, self.sin = math.cos(turn), math.sin(turn)
        self.way = p.shape().less(self.radius)
        rough = p.shape().less(self.radius + self.fal)
        if min(p.shape().a, p.shape().b) < self.radius + self.fal - NEAR:
            raise Refusal(
                f"the tool of {p.name}, {self.radius:g} with FAL {self.fal:g}, does not fit in it",
                "check the tool's radius and the sizes of the pocket",
            )
        self.inside = rough
        self.last = ""
        self._to("G0", z=self.rtp)
        self._to("G0", (0.0, 0.0))
        self._to("G0", z=self.rfp + self.clear)

    # -- roughing and finishing --------------------------------------------------------------------

    def rough(self) -> None:
        rings = self._rings(self.inside)
        high = self.rfp + self.clear
        for z in self._depths(self.dp + self.fald):
            self._enter(high, z)
            self._clear(rings)
            high = min(z + self.clear, self.rfp + self.clear)
            self._to("G0", z=high)
            self._to("G0", (0.0, 0.0))
        self._to("G0", z=self.rtp)

    def finish(self) -> None:
        if not self.fal and not self.fald:
            raise Refusal(
                f"{self.pocket.name} finishes nothing: FAL and FALD are 0",
                "write the allowances that roughing has left, or take the call out",
            )
        for z in self._depths(self.dp + self.fald) if self.fal else ():
            self._to("G0", z=z)
            self._wall()
        if self.fald:
            self._to("G0", z=self.dp + self.fald + self.clear)
            self._to("G1", z=self.dp, feed=self.down)
            self._clear(self._rings(self.way))
            self._to("G0", z=self.dp + self.fald + self.clear)
            self._to("G0", (0.0, 0.0))
        self._to("G0", z=self.rtp)

    def _wall(self) -> None:
        """Once along the wall from the middle and back to it."""
        a, b = self.way.a, self.way.b
        r = min(JOIN_MM / (25.4 if self.tracker.inch else 1.0), a / 2, b / 2)
        middle = a - r, 0.0
        on = Piece(1, (a - r, -r), (a, 0.0), middle)
        off = Piece(1, (a, 0.0), (a - r, r), middle)
        around = self.way.ring() if r > NEAR else []
        self._pieces([on, *around, off] if around else [])
        self._to("G1", (0.0, 0.0), feed=self.plane)

    def _clear(self, rings: list[Rounded]) -> None:
        for ring in rings:
            self._to("G1", ring.start, feed=self.plane)
            self._pieces(ring.ring())

    def _rings(self, shape: Rounded) -> list[Rounded]:
        wide = self.pocket._get("MIDA") or 1.6 * self.radius
        try:
            return shape.rings(step_of(shape, min(wide, 2 * self.radius), self.radius))
        except ValueError:
            raise Refusal(f"{self.pocket.name} takes too many ways", "correct MIDA") from None

    def _depths(self, bottom: float) -> Iterator[float]:
        total, most = self.rfp - bottom, self.pocket._get("MID")
        count = math.ceil(total / most - NEAR) if most > 0 else 1
        if count > MOST_DEPTHS:
            raise Refusal(f"{self.pocket.name} takes too many depths", "correct MID")
        return (bottom if k == count else self.rfp - total * k / count for k in range(1, count + 1))

    def _enter(self, high: float, z: float) -> None:
        """Into a depth at the middle."""
        p = self.pocket
        way, r, pitch = int(p.given["VARI"]) // 10, p._get("RAD1"), p._get("DP1")
        if way == 2 and (r <= 0 or pitch <= 0):
            raise Refusal(f"{p.name} on a helix without RAD1 and DP1", "write them, above 0")
        if not way or r <= 0 or pitch <= 0:
            self._to("G1" if way else "G0", z=z, feed=self.down if way else "")
            return
        if r > min(self.inside.a, self.inside.b) + NEAR or (high - z) / pitch > MOST_DEPTHS:
            raise Refusal(
                f"the helix of {p.name}, RAD1 {r:g} by DP1 {pitch:g}, does not fit",
                "correct RAD1 and DP1",
            )
        self._to("G1", (r, 0.0), feed=self.plane)
        halves = 2 * math.ceil((high - z) / pitch - NEAR)
        for k in range(1, halves + 3):
            side = -r if k % 2 else r
            half = Piece(self.ccw, (-side, 0.0), (side, 0.0))
            depth = high + (z - high) * min(k, halves) / halves
            self._arc(half, z=depth if k <= halves else None, feed=self.down)

    # -- lines -------------------------------------------------------------------------------------

    def _pieces(self, pieces: list[Piece]) -> None:
        """A way that is written counter-clockwise, in the sense that is asked for."""
        if self.ccw < 0:
            mirror = lambda q: (q[0], -q[1])  # noqa: E731
            pieces = [
                Piece(-p.turn, mirror(p.start), mirror(p.end), mirror(p.centre)) for p in pieces
            ]
        for k, piece in enumerate(pieces):
            if not k:
                self._to("G1", piece.start, feed=self.plane)
            if piece.turn:
                self._arc(piece, feed=self.plane)
            else:
                self._to("G1", piece.end, feed=self.plane)

    def _arc(self, piece: Piece, z: float | None = None, feed: str = "") -> None:
        arm = piece.centre[0] - piece.start[0], piece.centre[1] - piece.start[1]
        words = " ".join(
            f"{letter}{number(v, self.tracker.decimals('I'))}"
            for letter, v in zip("IJ", self._turned(arm), strict=True)
        )
        self._to("G2" if piece.turn < 0 else "G3", piece.end, z, feed, words)

    def _turned(self, p: Point) -> Point:
        return p[0] * self.cos - p[1] * self.sin, p[0] * self.sin + p[1] * self.cos

    def _to(
        self,
        code: str,
        place: Point | None = None,
        z: float | None = None,
        feed: str = "",
        more: str = "",
    ) -> None:
        words = []
        if place is not None:
            x, y = self._turned(place)
            g = self.pocket.given
            words = [("X", g["PA"] + x), ("Y", g["PO"] + y)]
        words += [] if z is None else [("Z", z)]
        text = " ".join(f"{a}{number(v, self.tracker.decimals(a))}" for a, v in words)
        fed = "" if feed == self.last else feed
        self.last = feed or self.last
        self.lines.append(" ".join(t for t in (code, text, more) if t).encode() + fed.encode())
