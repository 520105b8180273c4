"""CYCLE77 of Sinumerik: circular spigots.

CYCLE77(RTP, RFP, SDIS, DP, DPR, PRAD, PA, PO, MID, FAL, FALD, FFP1, FFD, CDIR, VARI, AP1): the
order of the values as in MaTka's Sinumerik snippets (marketplace.visualstudio.com). Siemens
"SINUMERIK 840D sl", Operating Manual Milling (03/2010), page 301, "Circular spigot (CYCLE77)",
"Approach/retraction":

- In rapid traverse at RTP to the start, on the spigot's positive first axis, and to SDIS above RFP;
  at FFD to the depth (even ones, MID at most), on a semicircle to the side at FFP1, once around it,
  and on a semicircle back to the start; at the end to RTP.
- VARI 1 leaves FAL at the side and FALD at the bottom, VARI 2 goes to both.
- CDIR 0 climb milling, 1 up-cut (with M3 with the clock and against it), 2 as G2, 3 as G3: as those
  of POCKET4.

        .--<--.
      .'       `.  .-->-.  off      on and off by half a circle each, between the start S, where it
     (  spigot   W       S          goes down and up in the open, and W on the way around
      `.       .'  `--<-'  on
        `-->--'

Assumed: the start lies 2 mm beside the blank, AP1 across, or, where none is stated, beside the way
around. The control goes around once, whatever the blank. Refused: G91, other planes.
"""

from __future__ import annotations

from postproc.nc.cycles.pocket_path import Piece
from postproc.nc.cycles.rounded import Rounded
from postproc.nc.expand import Refusal
from postproc.nc.expand.siemens_milling import WITH_M3, Milling, Ways, ending
from postproc.nc.expand.tracker import Tracker

BESIDE_MM = 2.0
NAMES = {"CYCLE77": "RTP RFP SDIS DP DPR PRAD PA PO MID FAL FALD FFP1 FFD CDIR VARI AP1"}


class Spigot(Milling):
    """A call with its values."""

    words = NAMES
    needed = "RTP RFP PRAD PA PO FFP1 FFD VARI"

    def check(self) -> None:
        given = self.given
        super().check()
        if self.get("DPR"):
            given["DP"] = given["RFP"] - abs(given["DPR"])
        self.needs("DP")
        self.check_kind((1, 2), "", "PRAD")
        if self.get("CDIR") not in WITH_M3:
            raise Refusal(f"CDIR of {self.name} is {given['CDIR']:g}", "0 to 3 are possible")
        if min(given["FFP1"], given["FFD"]) <= 0:
            raise Refusal(f"{self.name} without its feeds FFP1 and FFD", "write them, above 0")
        self.check_planes("FAL FALD MID SDIS AP1")
        if 0 < self.get("AP1") < 2 * given["PRAD"]:
            raise Refusal(
                f"the blank of {self.name} is {given['AP1']:g} across, and the spigot"
                f" {2 * given['PRAD']:g}",
                "write the diameter of the blank as AP1",
            )

    def lines(self, tracker: Tracker, feed: bytes, speed: bytes = b"") -> list[bytes]:
        """The plain lines; feed: the F word in force. Raises Refusal."""
        self.check_modes(tracker)
        g, radius = self.given, self.radius(tracker)
        rough = g["VARI"] == 1
        side = g["PRAD"] + radius + (self.get("FAL") if rough else 0.0)
        way = Rounded(side, side, side)
        start = self._start(way.a, radius, tracker.inch)
        cut = Ways(self, tracker)
        # around a spigot climb milling goes the other way than within a pocket
        kind = int(self.get("CDIR"))
        cut.ccw = WITH_M3[kind] * (-self.sense if kind < 2 else 1)
        # of both half circles, which run into the way around at W without a corner
        middle = ((way.a + start) / 2, 0.0)
        on, off = ((start, 0.0), way.start), (way.start, (start, 0.0))
        around = [Piece(-1, *on, middle), *way.ring(), Piece(-1, *off, middle)]
        cut.to("G0", z=g["RTP"])
        cut.to("G0", (start, 0.0))
        cut.to("G0", z=g["RFP"] + self.get("SDIS"))
        for z in self.depths(g["DP"] + (self.get("FALD") if rough else 0.0)):
            cut.to("G1", z=z, feed=cut.down)
            cut.pieces(around, at_start=True)
        cut.to("G0", z=g["RTP"])
        return [*cut.lines, *ending(tracker, feed)]

    def _start(self, side: float, radius: float, inch: bool) -> float:
        """Where the tool's middle begins on the first axis."""
        beside = BESIDE_MM / (25.4 if inch else 1.0)
        return max(self.get("AP1") / 2 + radius, side) + beside
