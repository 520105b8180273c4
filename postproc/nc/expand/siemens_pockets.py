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

from postproc.nc.cycles.pocket_path import Piece
from postproc.nc.cycles.rounded import Rounded, step_of
from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_milling import MOST_DEPTHS, NEAR, WITH_M3, Milling, Ways, ending
from postproc.nc.expand.tracker import Tracker

_ENDS = "MID FAL FALD FFP1 FFD CDIR VARI MIDA AP1"
NEEDED = {
    "POCKET3": "RTP RFP DP LENG WID PA PO FFP1 VARI",
    "POCKET4": "RTP RFP DP PRAD PA PO FFP1 VARI",
}
JOIN_MM = 2.0  # radius of the quarter circles at the wall
NAMES = {
    "POCKET3": f"RTP RFP SDIS DP LENG WID CRAD PA PO STA {_ENDS} AP2 AD RAD1 DP1",
    "POCKET4": f"RTP RFP SDIS DP PRAD PA PO {_ENDS} AD RAD1 DP1",
}


class Pocket(Milling):
    """A call with its values."""

    words = NAMES

    def check(self) -> None:
        self.needs(NEEDED[self.name])
        g = self.given
        self.check_kind((1, 2, 11, 12, 21, 22), "AP1 AP2 AD", "LENG WID")
        if self.get("CDIR") not in WITH_M3:
            raise Refusal(f"CDIR of {self.name} is {g['CDIR']:g}", "0 to 3 are possible")
        if g["FFP1"] <= 0 or (g["VARI"] != 1 and self.get("FFD") <= 0):
            raise Refusal(f"{self.name} without its feeds FFP1 and FFD", "write them, above 0")
        self.check_planes("FAL FALD MID MIDA SDIS")

    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        """The plain lines; feed: the F word in force. Raises Refusal."""
        self.check_modes(tracker)
        cut = _Cut(self, tracker, self.radius(tracker))
        if self.given["VARI"] % 10 == 1:
            cut.rough()
        else:
            cut.finish()
        return [*cut.lines, *ending(tracker, feed)]

    def shape(self) -> Rounded:
        """The wall."""
        g = self.given
        if self.name == "POCKET4":
            return Rounded(g["PRAD"], g["PRAD"], g["PRAD"])
        return Rounded(
            g["LENG"] / 2, g["WID"] / 2, min(self.get("CRAD"), g["LENG"] / 2, g["WID"] / 2)
        )


class _Cut(Ways):
    """Writes one pocket."""

    def __init__(self, pocket: Pocket, tracker: Tracker, radius: float):
        super().__init__(pocket, tracker)
        self.pocket, self.radius = pocket, radius
        g, p = pocket.given, pocket
        self.rtp, self.rfp, self.dp = g["RTP"], g["RFP"], g["DP"]
        self.clear, self.fal, self.fald = (p.get(w) for w in ("SDIS", "FAL", "FALD"))
        # climb and up-cut hang on how the spindle turns, G2 and G3 do not
        self.ccw = WITH_M3[int(p.get("CDIR"))] * (self.pocket.sense if p.get("CDIR") < 2 else 1)
        self.way = p.shape().less(self.radius)
        # the ways of the tool's middle: the wall moved in by the radius, and by what is left for
        # finishing
        rough = p.shape().less(self.radius + self.fal)
        if min(p.shape().a, p.shape().b) < self.radius + self.fal - NEAR:
            raise Refusal(
                f"the tool of {p.name}, {self.radius:g} with FAL {self.fal:g}, does not fit in it",
                "check the tool's radius and the sizes of the pocket",
            )
        self.inside = rough
        self.to("G0", z=self.rtp)
        self.to("G0", (0.0, 0.0))
        self.to("G0", z=self.rfp + self.clear)

    # -- roughing and finishing --------------------------------------------------------------------

    def rough(self) -> None:
        rings = self._rings(self.inside)
        high = self.rfp + self.clear
        for z in self.pocket.depths(self.dp + self.fald):
            self._enter(high, z)
            self._clear(rings)
            # to SDIS above what is cleared by now, and in rapid traverse back to the middle
            high = min(z + self.clear, self.rfp + self.clear)
            self.to("G0", z=high)
            self.to("G0", (0.0, 0.0))
        self.to("G0", z=self.rtp)

    def finish(self) -> None:
        if not self.fal and not self.fald:
            raise Refusal(
                f"{self.pocket.name} finishes nothing: FAL and FALD are 0",
                "write the allowances that roughing has left, or take the call out",
            )
        # the wall down to what roughing has left at the bottom, and the bottom by itself behind it
        for z in self.pocket.depths(self.dp + self.fald) if self.fal else ():
            self.to("G0", z=z)
            self._wall()
        if self.fald:
            self.to("G0", z=self.dp + self.fald + self.clear)
            self.to("G1", z=self.dp, feed=self.down)
            self._clear(self._rings(self.way))
            self.to("G0", z=self.dp + self.fald + self.clear)
            self.to("G0", (0.0, 0.0))
        self.to("G0", z=self.rtp)

    def _wall(self) -> None:
        """Once along the wall from the middle and back to it."""
        self.pieces(self.way.joined(JOIN_MM / (25.4 if self.tracker.inch else 1.0)))
        self.to("G1", (0.0, 0.0), feed=self.plane)

    def _clear(self, rings: list[Rounded]) -> None:
        for ring in rings:
            self.to("G1", ring.start, feed=self.plane)
            self.pieces(ring.ring())

    def _rings(self, shape: Rounded) -> list[Rounded]:
        # 0.8 of the diameter
        wide = self.pocket.get("MIDA") or 1.6 * self.radius
        try:
            return shape.rings(step_of(shape, min(wide, 2 * self.radius), self.radius))
        except ValueError:
            raise Refusal(f"{self.pocket.name} takes too many ways", "correct MIDA") from None

    def _enter(self, high: float, z: float) -> None:
        """Into a depth at the middle."""
        p = self.pocket
        way, r, pitch = int(p.given["VARI"]) // 10, p.get("RAD1"), p.get("DP1")
        if way == 2 and (r <= 0 or pitch <= 0):
            raise Refusal(f"{p.name} on a helix without RAD1 and DP1", "write them, above 0")
        if not way or r <= 0 or pitch <= 0:
            self.to("G1" if way else "G0", z=z, feed=self.down if way else "")
            return
        if r > min(self.inside.a, self.inside.b) + NEAR or (high - z) / pitch > MOST_DEPTHS:
            raise Refusal(
                f"the helix of {p.name}, RAD1 {r:g} by DP1 {pitch:g}, does not fit",
                "correct RAD1 and DP1",
            )
        # Half a turn a block, DP1 at most in two of them, and once more around at the depth.
        self.to("G1", (r, 0.0), feed=self.plane)
        halves = 2 * math.ceil((high - z) / pitch - NEAR)
        for k in range(1, halves + 3):
            side = -r if k % 2 else r
            half = Piece(self.ccw, (-side, 0.0), (side, 0.0))
            depth = high + (z - high) * min(k, halves) / halves
            self.arc(half, z=depth if k <= halves else None, feed=self.down)
