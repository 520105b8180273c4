"""CYCLE71 of Sinumerik: a rectangular surface milled in parallel ways.

CYCLE71(RTP, RFP, SDIS, DP, PA, PO, LENG, WID, STA, MID, MIDA, FDP, FALD, FFP1, VARI, FDP1): order,
levels and ends of the ways as in daviderobrtoalovisi/toleranza0, js/interpreter/siemens-facing.js,
and in a STEP-NC translator that quotes the manual of the cycle (FDP "retraction travel in cutting
direction", FDP1 "overrun on last cut as determined by the cutting edge geometry").

- PA PO is a corner; the signs of LENG and WID say to which side of it the surface lies, turned by
  STA. VARI: 1x along the first axis, one way, 2x along the second, 3x and 4x the same to and fro;
  x 1 roughing down to FALD above DP in even depths, MID at most; x 2 finishing, once at DP.
- In rapid traverse to the first way, to SDIS above RFP, and to the depth, in the open: each way
  begins and ends FDP and the tool's radius outside of the surface.
- The first way is MIDA wide (0: 0.8 of the tool's diameter), so that its middle lies MIDA less the
  radius within the edge; the last one lies FDP1 less the radius beyond the other edge; those
  between are as far apart, MIDA at most. One way: drawn out to SDIS above what was there before,
  and in rapid traverse to the next. To and fro: over to the next at FFP1.
- At the end to RTP.

        FDP + R  :       LENG       : FDP + R
      o----------:------------------:--------->    first: MIDA - R within the edge: MIDA wide
      <----------:------------------:---------o    between: MIDA apart at most
      o----------:------------------:--------->    last: FDP1 - R beyond the other edge

Assumed: where the first and the last way lie within the edges; wherever they do, all of it is one
plane, and is cut all over. Refused: G91, other planes, G41 and G42, MIDA wider than the tool.
"""

from __future__ import annotations

import math

from postproc.nc.cycles.pocket_path import Point
from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_milling import NEAR, Milling, Ways, ending
from postproc.nc.expand.tracker import Tracker

KINDS = tuple(10 * way + kind for way in (1, 2, 3, 4) for kind in (1, 2))
MOST_WAYS = 10_000
NAMES = {"CYCLE71": "RTP RFP SDIS DP PA PO LENG WID STA MID MIDA FDP FALD FFP1 VARI FDP1"}


class Face(Milling):
    """A call with its values."""

    words = NAMES
    needed = "RTP RFP DP PA PO LENG WID FFP1 VARI"

    def check(self) -> None:
        super().check()
        self.check_kind(KINDS, "", "")
        self.check_planes("FALD MID MIDA SDIS FDP FDP1")
        if self.given["FFP1"] <= 0 or not self.given["LENG"] or not self.given["WID"]:
            raise Refusal(
                "CYCLE71 without a feed FFP1 above 0, or without LENG and WID", "correct the call"
            )

    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        """The plain lines; feed: the F word in force. Raises Refusal."""
        self.check_modes(tracker)
        g, ways, cut = self.given, self._ways(self.radius(tracker)), Ways(self, tracker)
        bottom, clear = g["DP"] + self.get("FALD"), self.get("SDIS")
        finishing, zigzag = g["VARI"] % 10 == 2, g["VARI"] >= 30
        before = bottom if finishing else g["RFP"]  # the surface of what is there
        cut.to("G0", ways[0][0])
        cut.to("G0", z=g["RFP"] + clear)
        for n, z in enumerate([g["DP"]] if finishing else self.depths(bottom)):
            for k, (start, end) in enumerate(ways):
                if k and zigzag:
                    cut.to("G1", start, feed=cut.plane)
                else:
                    if n or k:
                        cut.to("G0", start)
                    cut.to("G0", z=z)
                cut.to("G1", end, feed=cut.plane)
                if not zigzag or k == len(ways) - 1:
                    cut.to("G0", z=before + clear)
            before = z
        cut.to("G0", z=g["RTP"])
        return [*cut.lines, *ending(tracker, feed)]

    def _ways(self, radius: float) -> list[tuple[Point, Point]]:
        """From and to where the tool's middle goes, in the coordinates of the surface."""
        g, pattern = self.given, int(self.given["VARI"]) // 10
        along = pattern % 2  # 1: along the first axis
        long, wide = (g["LENG"], g["WID"]) if along else (g["WID"], g["LENG"])
        step = self.get("MIDA") or 1.6 * radius
        if step > 2 * radius + NEAR or abs(wide) / step > MOST_WAYS:
            raise Refusal(
                f"MIDA of CYCLE71 is {step:g}, and the tool is {2 * radius:g} wide",
                "write one up to the tool's diameter, and not too small",
            )
        out = math.copysign(radius + self.get("FDP"), long)
        first, last = step - radius, abs(wide) + self.get("FDP1") - radius
        count = max(math.ceil((last - first) / step - NEAR), 0)
        rows = [
            math.copysign(1.0, wide) * (first + (last - first) * k / max(count, 1))
            for k in range(count + 1)
        ]
        ends = (-out, long + out)
        found = []
        for k, row in enumerate(rows):
            turn = pattern >= 3 and k % 2 == 1
            pair = [(s, row) if along else (row, s) for s in (ends[::-1] if turn else ends)]
            found.append((pair[0], pair[1]))
        return found
