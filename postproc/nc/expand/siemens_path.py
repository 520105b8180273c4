"""CYCLE72 of Sinumerik: milling along a contour.

CYCLE72(KNAME, RTP, RFP, SDIS, DP, MID, FAL, FALD, FFP1, FFD, VARI, RL, AS1, LP1, FF3, AS2, LP2).
Siemens "SINUMERIK 840D sl/840D/840Di/810D", Cycles (11/2006), CYCLE72; the order of the values as
in MaTka's Sinumerik snippets.

- At each depth (even ones, MID at most) to the start of the approach, where cutter radius
  compensation goes on (RL 41 left, 42 right, 40 none), in rapid traverse to SDIS above RFP, at FFD
  to the depth, at FFP1 on the approach (AS1), along the contour, and on the departure (AS2); up,
  and compensation off.
- AS1, AS2: 1 a straight line LP1 (LP2) long along the tangent, 2 a quarter, 3 half of a circle,
  LP1 (LP2) the radius of the way of the tool's middle.
- VARI x1 leaves FAL beside the contour and FALD above DP, x2 goes to both; 1x: between the depths
  at FF3 instead of in rapid traverse.

Contour, approach, depths and sides are those of the manual. Assumed: between the depths the tool is
at RTP, where the control may stay lower (hundreds of VARI), and compensation goes on and off there;
off, the tool's middle stays where it is. The radius is D's.
Refused: approaches in space (AS1 1x), arcs and FAL without compensation, G91, other planes, G41 and
G42 before it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from postproc.nc.cycles.pocket_path import DoesNotFit, Piece, Point, beside
from postproc.nc.cycles.scene import CLOCKWISE, COUNTER
from postproc.nc.expand.siemens_contour import elements
from postproc.nc.expand.siemens_milling import Milling, Ways, ending
from postproc.nc.expand.siemens_values import Refusal, Value, numbers_by_name
from postproc.nc.expand.tracker import Tracker, number

NAME = "CYCLE72"
WORDS = "RTP RFP SDIS DP MID FAL FALD FFP1 FFD VARI RL AS1 LP1 FF3 AS2 LP2"
KINDS = tuple(100 * up + 10 * between + kind
              for up in range(4) for between in (0, 1) for kind in (1, 2))  # fmt: skip
TURN = {CLOCKWISE: -1, COUNTER: 1}
SIDE = {40: 0, 41: 1, 42: -1}
LINE, QUARTER, HALF = 1, 2, 3


@dataclass
class Path(Milling):
    """A call with its values; `contour`: the plain lines that KNAME names."""

    contour: list[bytes] = field(default_factory=list)

    @classmethod
    def of(cls, values: Sequence[Value | None], contour: Callable[[str], list[bytes]]) -> Path:
        """contour: the lines of one by its name. Raises Refusal for values that are none of the
        cycle."""
        given = numbers_by_name(NAME, WORDS.split(), values[1:], "correct the call")
        path = cls(NAME, given)
        path.needs("RTP RFP DP FFP1 FFD VARI RL AS1 LP1")
        along = given["RL"] == 40 and given["VARI"] % 10 == 1
        path.check_kind(KINDS, "FAL" if along else "", "")
        path.check_planes("FAL FALD MID SDIS LP1 LP2")
        given.setdefault("AS2", given["AS1"])
        given.setdefault("LP2", given["LP1"])
        for word in ("AS1", "AS2"):
            lines = (LINE,) if given["RL"] == 40 else (LINE, QUARTER, HALF)
            if given["RL"] not in SIDE or given[word] not in lines:
                raise Refusal(
                    f"CYCLE72 with RL={given['RL']:g} and {word}={given[word]:g}",
                    "write 1, 2 or 3 with RL 41 or 42, 1 with RL 40, or the ways as G1, G2 and G3",
                )
        if min(given["FFP1"], given["FFD"]) <= 0:
            raise Refusal("CYCLE72 without its feeds FFP1 and FFD", "write them, above 0")
        name = values[0]
        if not isinstance(name, str) or not name:
            raise Refusal("CYCLE72 without a contour", "write its name as the first value")
        path.contour = contour(name)
        return path

    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        """The plain lines; feed: the F word in force. Raises Refusal."""
        self.check_modes(tracker)
        g = self.given
        rough, side = g["VARI"] % 10 == 1, SIDE[int(g["RL"])]
        radius = self.radius(tracker) if side else 0.0
        way = self._way(tracker, side, rough, radius)
        (x, y), t = way[-1].end, way[-1].tangent(True)
        middle = x - side * radius * t[1], y + side * radius * t[0]  # of the tool at its end
        cut = Ways(self, tracker)
        on = "" if not side else f" G{int(g['RL'])}"
        slow = int(g["VARI"]) // 10 % 10 and self.get("FF3")
        cut.to("G0", z=g["RTP"])
        for k, z in enumerate(self.depths(g["DP"] + (self.get("FALD") if rough else 0.0))):
            if slow and k:
                cut.to(f"G1{on}", way[0].start, feed=f" F{number(g['FF3'], 3)}")
            else:
                cut.to(f"G0{on}", way[0].start)
            cut.to("G0", z=g["RFP"] + self.get("SDIS"))
            cut.to("G1", z=z, feed=cut.down)
            cut.pieces(way, begun=True)
            cut.to("G0", z=g["RTP"])
            if side:
                cut.to("G0 G40", middle)
        return [*cut.lines, *ending(tracker, feed)]

    def _way(self, tracker: Tracker, side: int, rough: bool, radius: float) -> list[Piece]:
        """Approach, contour and departure."""
        g, allowance = self.given, self.get("FAL") if rough else 0.0
        shape = [
            Piece(TURN.get(e.code, 0), e.start, e.end, e.centre)
            for e in elements(tracker, self.contour, NAME, "XY")
        ]
        if allowance and side:
            try:
                shape = beside(shape, allowance, side, closed=False)
            except DoesNotFit:
                raise Refusal(
                    f"the contour of CYCLE72 leaves no room for FAL {allowance:g}",
                    "check FAL, or let the CAM program write it out",
                ) from None
        first, last = shape[0], shape[-1]
        on = self._joined(first.start, first.tangent(False), side, (int(g["AS1"]), g["LP1"]),
                          radius)  # fmt: skip
        back = last.tangent(True)
        off = self._joined(last.end, (-back[0], -back[1]), -side, (int(g["AS2"]), g["LP2"]), radius)
        turned = Piece(-off.turn, off.end, off.start, off.centre)
        return [p for p in (on, *shape, turned) if p.start != p.end or p.turn]

    @staticmethod
    def _joined(at: Point, way: Point, side: int, how: tuple[int, float], radius: float) -> Piece:
        """What comes to a place along the way's direction there."""
        kind, length = how
        if kind == LINE:
            return Piece(0, (at[0] - length * way[0], at[1] - length * way[1]), at)
        r = length + radius
        to_left = -side * way[1], side * way[0]
        centre = at[0] + r * to_left[0], at[1] + r * to_left[1]
        if kind == QUARTER:
            return Piece(side, (centre[0] - r * way[0], centre[1] - r * way[1]), at, centre)
        return Piece(side, (centre[0] + r * to_left[0], centre[1] + r * to_left[1]), at, centre)
