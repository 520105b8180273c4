"""Canned cycles and turned, scaled or mirrored coordinates, written out as plain blocks.

One family of controls and of cycles per module; which dialect has which is said here and nowhere
else. A new family is a new module and a row.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from postproc.nc.codes import code_number
from postproc.nc.cycles.arcs_placed_siemens import PlacedArcs
from postproc.nc.cycles.arcs_siemens import Openings
from postproc.nc.cycles.before import Before, Chain
from postproc.nc.cycles.block_feed_siemens import BlockFeed
from postproc.nc.cycles.blocks_okuma_lathe import LatheBlocks
from postproc.nc.cycles.bolt_holes_haas import BoltHoles
from postproc.nc.cycles.circular_haas import CLOCKWISE, COUNTER, CircularPocket
from postproc.nc.cycles.corners_fanuc import FanucCorners
from postproc.nc.cycles.corners_heidenhain import IsoCorners
from postproc.nc.cycles.cycle import Cycle
from postproc.nc.cycles.direction_fanuc import ToolDirections
from postproc.nc.cycles.direction_siemens import SiemensDirections
from postproc.nc.cycles.drilling_fadal import FADAL, FadalDrilling
from postproc.nc.cycles.drilling_fagor import FAGOR, TAP, FagorDrilling
from postproc.nc.cycles.drilling_fanuc import (
    LATHE,
    MILL,
    MILL_REFUSED,
    FanucDrilling,
    HaasDrilling,
    LatheDrilling,
)
from postproc.nc.cycles.drilling_haas_lathe import HAAS_LATHE, HaasLatheDrilling
from postproc.nc.cycles.drilling_linuxcnc import ACTIONS, REFUSED, LinuxcncDrilling
from postproc.nc.cycles.drilling_okuma import LEVEL, OKUMA, TAPS, OkumaDrilling, ReturnLevel
from postproc.nc.cycles.drilling_okuma_lathe import DRILL, LiveDrilling
from postproc.nc.cycles.engraving_haas import CODE as ENGRAVING
from postproc.nc.cycles.engraving_haas import Engraving
from postproc.nc.cycles.frame_control import FrameControl
from postproc.nc.cycles.frames_fanuc import FanucFrames
from postproc.nc.cycles.frames_haas import HaasFrames
from postproc.nc.cycles.frames_siemens import SiemensFrames
from postproc.nc.cycles.grooving_fanuc import Grooving
from postproc.nc.cycles.grooving_okuma import OkumaGrooving
from postproc.nc.cycles.holes_heidenhain import IsoHoles
from postproc.nc.cycles.klartext_turns import KlartextTurns
from postproc.nc.cycles.nurbs_fanuc import NURBS, FanucNurbs
from postproc.nc.cycles.pocket_haas import CODE as POCKET
from postproc.nc.cycles.pocket_haas import Pocket
from postproc.nc.cycles.pole_heidenhain import PoleArcs
from postproc.nc.cycles.polynomials_siemens import Polynomials
from postproc.nc.cycles.rotation_linuxcnc import LinuxcncRotation
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.spline_marlin import SPLINE, MarlinSpline
from postproc.nc.cycles.splines import Splines
from postproc.nc.cycles.threading import LinuxcncThread
from postproc.nc.cycles.turning_fanuc import Repetitive
from postproc.nc.cycles.turning_linuxcnc import LinuxcncTurning
from postproc.nc.cycles.turning_single import Stays, Turn
from postproc.nc.dialects import Dialect


@dataclass(frozen=True)
class Family:
    """The cycles of a dialect by ten times their G number, and its frames. `restores`: G80 brings
    back the motion code (G0 G1 G2 G3) that was in force before the cycle; `forgets`: nobody knows
    which one it leaves. `until_g80`: a motion code does not end a cycle. `parts`: what writes out
    what depends on blocks around it, in this order: roundings, arcs about a pole."""

    cycles: dict[int, Cycle] = field(default_factory=dict)
    control: type[FrameControl] | None = None
    restores: bool = False
    forgets: bool = False
    until_g80: bool = False
    parts: tuple[type[Before], ...] = ()

    def before(self, scene: Scene) -> Before | None:
        """What looks at lines before cycles and frames do."""
        return Chain([part(scene) for part in self.parts]) if self.parts else None

    @property
    def codes(self) -> set[int]:
        """All that are written out but for those of frames."""
        return {*self.cycles, *(code for part in self.parts for code in part.codes)}


def linuxcnc(dialect: Dialect, synchronised: bool) -> Family:
    holes = LinuxcncDrilling(synchronised)
    cycles: dict[int, Cycle] = dict.fromkeys([*ACTIONS, *REFUSED], holes)
    turning = dict.fromkeys((700, 710, 711, 712, 720, 721, 722), LinuxcncTurning())
    splines = Splines()
    cycles |= dict.fromkeys(splines.codes, splines)
    return Family(cycles | {760: LinuxcncThread()} | turning, LinuxcncRotation)


def grblhal(dialect: Dialect, synchronised: bool) -> Family:
    """Its holes and threads stay: they are not measured."""
    splines = Splines(nurbs=False)
    return Family(dict.fromkeys(splines.codes, splines))


def fanuc_mill(dialect: Dialect, synchronised: bool) -> Family:
    holes = FanucDrilling(synchronised)
    cycles: dict[int, Cycle] = dict.fromkeys([*MILL, *MILL_REFUSED], holes)
    cycles[NURBS] = FanucNurbs()
    return Family(cycles, FanucFrames, restores=True, parts=(FanucCorners, ToolDirections))


def haas(dialect: Dialect, synchronised: bool) -> Family:
    drilling = HaasDrilling(synchronised)
    cycles: dict[int, Cycle] = dict.fromkeys([*MILL, *MILL_REFUSED], drilling)
    cycles |= dict.fromkeys((CLOCKWISE, COUNTER), CircularPocket())
    cycles |= {ENGRAVING: Engraving(), POCKET: Pocket()}

    class Bolts(BoltHoles):
        holes = drilling

    return Family(cycles, HaasFrames, restores=True, parts=(Bolts, FanucCorners))


def fanuc_lathe(dialect: Dialect, synchronised: bool) -> Family:
    system = next((s for s in SYSTEMS if dialect.name.endswith("-" + s)), "b")
    turning = _turning(system)
    return replace(
        turning, cycles=dict.fromkeys(LATHE, LatheDrilling(synchronised)) | turning.cycles
    )


def haas_lathe(dialect: Dialect, synchronised: bool) -> Family:
    """Turning as in system A; R of its holes is a place, unlike Fanuc's."""
    turning, holes = _turning("a", haas=True), HaasLatheDrilling(synchronised)
    return replace(turning, cycles=dict.fromkeys(HAAS_LATHE, holes) | turning.cycles)


def _turning(system: str, haas: bool = False) -> Family:
    finish, rough, face, repeat, peck, groove, thread, turn, single, end = SYSTEMS[system]
    roles = {finish: "finish", rough: "rough", face: "face", repeat: "repeat"}
    cycles: dict[int, Cycle] = dict.fromkeys(roles, Repetitive(roles, haas))
    cycles |= {peck: Grooving("Z", haas), groove: Grooving("X", haas)}
    cycles |= {
        thread: Stays(False),
        turn: Turn(False, haas),
        single: Stays(True),
        end: Turn(True, haas),
    }
    return Family(cycles, restores=True, parts=(FanucCorners,))


SIEMENS = (BlockFeed, SiemensDirections, Openings, PlacedArcs, Polynomials)
SYSTEMS = {  # G70 to G76 and G90 G92 G94, as the three G-code systems of a Fanuc lathe have them
    "a": (700, 710, 720, 730, 740, 750, 760, 900, 920, 940),
    "b": (700, 710, 720, 730, 740, 750, 760, 770, 780, 790),
    "c": (720, 730, 740, 750, 760, 770, 780, 200, 210, 240),
}


def siemens(dialect: Dialect, synchronised: bool) -> Family:
    return Family(control=SiemensFrames, parts=SIEMENS)


def heidenhain_iso(dialect: Dialect, synchronised: bool) -> Family:
    return Family(parts=(IsoCorners, IsoHoles, PoleArcs))


def heidenhain(dialect: Dialect, synchronised: bool) -> Family:
    return Family(parts=(KlartextTurns,))


def marlin(dialect: Dialect, synchronised: bool) -> Family:
    return Family({SPLINE: MarlinSpline()})


def fagor(dialect: Dialect, synchronised: bool) -> Family:
    holes = FagorDrilling(synchronised)
    return Family(dict.fromkeys([*FAGOR, TAP], holes), forgets=True, until_g80=True)


def fadal(dialect: Dialect, synchronised: bool) -> Family:
    return Family(dict.fromkeys(FADAL, FadalDrilling(synchronised)), restores=True)


def okuma(dialect: Dialect, synchronised: bool) -> Family:
    holes = OkumaDrilling(synchronised)
    cycles: dict[int, Cycle] = dict.fromkeys([*OKUMA, *TAPS], holes)
    return Family(cycles | {LEVEL: ReturnLevel(holes)}, forgets=True)


def okuma_lathe(dialect: Dialect, synchronised: bool) -> Family:
    threads: dict[int, Cycle] = dict.fromkeys((310, 320, 330), Stays(True))
    threads |= dict.fromkeys((710, 720, 770, 780), Stays(False))
    cycles = threads | {DRILL: LiveDrilling(), 730: OkumaGrooving("X"), 740: OkumaGrooving("Z")}
    return Family(cycles, forgets=True, parts=(LatheBlocks, FanucCorners))


# the longest prefix of the dialect's name holds
FAMILIES: dict[str, Callable[[Dialect, bool], Family]] = {
    "linuxcnc": linuxcnc,
    "grblhal": grblhal,
    "fanuc": fanuc_mill,
    "fanuc-lathe": fanuc_lathe,
    "siemens": siemens,
    "marlin": marlin,
    "heidenhain": heidenhain,
    "heidenhain-iso": heidenhain_iso,
    "haas": haas,
    "haas-lathe": haas_lathe,
    "fadal": fadal,
    "fagor": fagor,
    "okuma": okuma,
    "okuma-lathe": okuma_lathe,
}


def family(dialect: Dialect, synchronised: bool = False) -> Family:
    """The cycles and frames of a dialect; none where they are not written."""
    found = max((p for p in FAMILIES if dialect.name.startswith(p)), key=len, default="")
    if not found:
        return Family()
    every = FAMILIES[found](dialect, synchronised)
    known = {code_number(code.word) for code in dialect.codes}
    return replace(every, cycles={n: cycle for n, cycle in every.cycles.items() if n in known})
