"""Drilling cycles of Haas lathes: G81 to G89 along Z, G241 to G249 along X (radial, with the live
tool).

Haas lathe operator's manual 96-8900, G81 to G89, G241 to G249: R is the R plane, a place, on radial
cycles a diameter like X. As Autodesk's posts write them (`haas lathe.cps`, function onCyclePoint):
X Z R F, with P, Q or I J K, one hole a cycle.

Assumed: the way back ends where the axis stood when the cycles began. The manual's text leaves open
whether it ends there or at R; the former is the farther one, from where the next motion is free,
and a notice says so. Without R a hole begins where the axis stands. Q and I J K are radii, pecks as
on Haas mills.
"""

from __future__ import annotations

from postproc.nc.cycles.block import Block
from postproc.nc.cycles.cycle import Outcome
from postproc.nc.cycles.drilling import KIND, WORDS, Action, bore, bore_standing, drill, pecks
from postproc.nc.cycles.drilling_fanuc import HAAS_PECKS, HaasDrilling
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.words import Form, named

AXIAL: dict[int, Action] = {
    810: drill, 820: drill, 830: pecks, 850: bore, 860: bore_standing, 890: bore,
}  # fmt: skip
# G241 is G81 along X
RADIAL: dict[int, Action] = {code + 1600: action for code, action in AXIAL.items()}
TAPS_ALONG_X = (1950, 1960)
TAPS = (840, 950, 1840, 1860, *TAPS_ALONG_X)
BY_HAND = dict.fromkeys((870, 880, 2470, 2480), "the operator draws the tool out by hand")
DWELLS = (820, 830, 890, 2420, 2430, 2490)
UNCERTAIN = "from where it counts the bottom is not certain"


class HaasLatheDrilling(HaasDrilling):
    """`held` as on mills; R and the bottom of radial holes are diameters."""

    actions = AXIAL | RADIAL | dict.fromkeys(TAPS, bore)
    tapping, refused = TAPS, BY_HAND
    words, repeats = "RPQIJK", ""
    dwells, pecking = DWELLS, (830, 2430)

    def hole_form(self, code: int) -> Form:
        along_x = self._along_x(code)
        place, depth = ("Z", "X") if along_x else ("X", "Z")
        by, down = ("W", "U") if along_x else ("U", "W")
        takes = {
            place: "place",
            by: f"place, from where {place} stands",
            "Y": "place",
            "C": "place",
            "H": "place of C, from where it stands",
        }
        takes |= {depth: "bottom", "R": WORDS["R"]}
        takes |= {"P": WORDS["P"]} if code in self.dwells else {}
        takes |= HAAS_PECKS | named(WORDS, "Q") if code in self.pecking else {}
        return Form(KIND, takes, refused={down: UNCERTAIN, "L": "how often"})

    def axis_of(self, scene: Scene, code: int) -> str:
        return "X" if self._along_x(code) else "Z"

    def _along_x(self, code: int) -> bool:
        return code in RADIAL or code in TAPS_ALONG_X or code in (2470, 2480)

    def run(self, scene: Scene, block: Block, code: int) -> Outcome:
        outcome = super().run(scene, block, code)
        axis = self.axis_of(scene, code)
        # `loose` says that nothing may count from there (a W or U): the next block names a place.
        if "R" not in self.held or not scene.differs(axis, self.held["R"]):
            return outcome
        back, level = (scene.text(axis, v).decode() for v in (scene.at(axis), self.held["R"]))
        what = (
            f"behind G{code / 10:g} the tool goes back to {back}, where it stood before: the manual"
            f" leaves open whether the control ends there or at R, {level}"
        )
        scene.tell("way back", what)
        return outcome._replace(loose=axis)

    def _hold(self, scene: Scene, block: Block, axis: str) -> None:
        super()._hold(scene, block, axis)
        self.r_from_start(scene, axis)
        if scene.is_diameter(axis):
            for word in block.words:
                # Pecks are radii as X's words are not: along X they count twice, like R and the
                # bottom.
                if word.letter in "IJK" and word.value is not None:
                    self.held[word.letter] = 2 * abs(scene.length(word, axis))
