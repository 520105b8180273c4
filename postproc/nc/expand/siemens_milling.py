"""What Sinumerik's milling cycles share: their call with its values, the modes in which they are
written out, the radius of the tool, and how ways are written."""

from __future__ import annotations

import math
from collections.abc import Iterator

from postproc.nc.cycles.pocket_path import Piece, Point
from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_cycle import Cycle, in_diameters
from postproc.nc.expand.tracker import Tracker, number
from postproc.nc.state import NONE

MOST_DEPTHS = 1000
NEAR = 1e-6
WRITE_OUT = "let the CAM program write it out as G0, G1, G2 and G3"
WITH_M3 = {0: 1, 1: -1, 2: -1, 3: 1}  # the sense about a pocket by _CDIR, counter-clockwise 1


class Milling(Cycle):
    """A call with its values."""

    def check_kind(self, kinds: tuple[int, ...], zero: str, positive: str) -> None:
        """Values in a way that is written out: VARI one of `kinds`, those in `zero` 0, those in
        `positive` not below 0. Raises Refusal."""
        g = self.given
        odd = [w for w in zero.split() if self.get(w)]
        odd += [w for w in positive.split() if g.get(w, 0.0) < 0]
        odd += [] if g["VARI"] in kinds else ["VARI"]
        if odd:
            raise Refusal(
                f"{self.name} with {odd[0]}={g[odd[0]]:g}, in a way that is not written out",
                WRITE_OUT,
            )

    def check_planes(self, allowances: str) -> None:
        """Raises Refusal where they are not in order, or one of the allowances is below 0."""
        g = self.given
        up = g["RTP"] >= g["RFP"] + self.get("SDIS") >= g["RFP"] > g["DP"] + self.get("FALD")
        if not up or min(self.get(w) for w in allowances.split()) < 0:
            raise Refusal(
                f"the planes of {self.name} are not in order",
                "RTP, RFP + SDIS, RFP and DP + FALD in this order; no allowance below 0",
            )

    def check_modes(self, tracker: Tracker) -> None:
        """Raises Refusal where the cycle is called in other modes than it is written out in."""
        plane, relative = tracker.code("plane"), tracker.code("distance") == 910
        if plane not in (-1, 170) or relative or in_diameters(tracker, "X"):
            raise Refusal(
                f"{self.name} outside of G17, in G91 or in diameters",
                "write G17 G90 DIAMOF before it",
            )
        if tracker.code("cutter") in (410, 420):
            raise Refusal(f"{self.name} while G41 or G42 is in force", "write G40 before it")

    def radius(self, tracker: Tracker) -> float:
        """Of the tool, program's unit. Raises Refusal."""
        held = tracker.state.beside
        d = 1 if held.offset == NONE else held.offset
        names = (f"D{d}", f"T{held.tool}D{d}")
        if not d:
            raise Refusal(f"{self.name} with D0, which has no radius", "write the tool's D before")
        radius = next((r for n in names if (r := tracker.offset(n, "R"))), None)
        if not radius:
            raise Refusal(
                f"the tool's radius D{d} of {self.name} is not stated",
                f"say it in mm: --offset D{d}=Z0,R5",
            )
        return radius / 25.4 if tracker.inch else radius

    def depths(self, bottom: float) -> Iterator[float]:
        """Even ones from the reference plane to `bottom`, MID at most; MID 0: at once. Raises
        Refusal."""
        rfp = self.given["RFP"]
        total, most = rfp - bottom, self.get("MID")
        count = math.ceil(total / most - NEAR) if most > 0 else 1
        if count > MOST_DEPTHS:
            raise Refusal(f"{self.name} takes too many depths", "correct MID")
        # the last one is the number of the call itself, not the sum of steps
        return (bottom if k == count else rfp - total * k / count for k in range(1, count + 1))


def ending(tracker: Tracker, feed: bytes) -> list[bytes]:
    """The motion code and the F that were in force before a cycle."""
    end = b" ".join([*tracker.motion_code(), *([b"F" + feed] if feed else [])])
    return [end] if end else []


class Ways:
    """Writes ways in the coordinates of a figure whose zero lies in PA PO, and that STA turns.
    `ccw`: the sense of ways that are told counter-clockwise, -1: the other."""

    def __init__(self, call: Milling, tracker: Tracker):
        g = call.given
        self.tracker, self.zero = tracker, (call.get("PA"), call.get("PO"))
        #      y'  ^  STA      x' y' are the coordinates of the figure, in which all ways are told:
        #       `. |  .' x'    zero is PA PO in those of the program, and STA turns x' from X.
        #         `|.'____ X
        turn = math.radians(call.get("STA"))
        self.cos, self.sin = math.cos(turn), math.sin(turn)
        self.plane = f" F{number(g['FFP1'], 3)}"
        self.down = f" F{number(call.get('FFD') or g['FFP1'], 3)}"
        self.ccw, self.last = 1, ""
        self.lines: list[bytes] = []

    def pieces(self, pieces: list[Piece], at_start: bool = False) -> None:
        """A way that is told counter-clockwise, in the sense that is asked for; at_start: the tool
        stands at its start."""
        # the same way seen in a mirror along the first axis runs the other way round
        if self.ccw < 0:

            def mirror(q: tuple[float, float]) -> tuple[float, float]:
                return q[0], -q[1]

            pieces = [
                Piece(-p.turn, mirror(p.start), mirror(p.end), mirror(p.centre)) for p in pieces
            ]
        for k, piece in enumerate(pieces):
            if not k and not at_start:
                self.to("G1", piece.start, feed=self.plane)
            if piece.turn:
                self.arc(piece, feed=self.plane)
            else:
                self.to("G1", piece.end, feed=self.plane)

    def arc(self, piece: Piece, z: float | None = None, feed: str = "") -> None:
        """G2 or G3 to the end of a piece, a helix with z."""
        arm = piece.centre[0] - piece.start[0], piece.centre[1] - piece.start[1]
        words = " ".join(
            f"{letter}{number(v, self.tracker.decimals('I'))}"
            for letter, v in zip("IJ", self._turned(arm), strict=True)
        )
        self.to("G2" if piece.turn < 0 else "G3", piece.end, z, feed, words)

    def _turned(self, p: Point) -> Point:
        return p[0] * self.cos - p[1] * self.sin, p[0] * self.sin + p[1] * self.cos

    def to(
        self,
        code: str,
        place: Point | None = None,
        z: float | None = None,
        feed: str = "",
        more: str = "",
    ) -> None:
        """A block to a place of the figure; `feed` is written where it is another one."""
        words = []
        if place is not None:
            x, y = self._turned(place)
            words = [("X", self.zero[0] + x), ("Y", self.zero[1] + y)]
        words += [] if z is None else [("Z", z)]
        text = " ".join(f"{a}{number(v, self.tracker.decimals(a))}" for a, v in words)
        fed = "" if feed == self.last else feed
        self.last = feed or self.last
        self.lines.append(" ".join(t for t in (code, text, more) if t).encode() + fed.encode())
