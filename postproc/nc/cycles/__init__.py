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
from postproc.nc.cycles.circular_haas import CircularPocket
from postproc.nc.cycles.corners_fanuc import FanucCorners
from postproc.nc.cycles.corners_heidenhain import IsoCorners
from postproc.nc.cycles.cycle import Cycle
from postproc.nc.cycles.direction_fanuc import ToolDirections
from postproc.nc.cycles.direction_siemens import SiemensDirections
from postproc.nc.cycles.drilling_fadal import FadalDrilling
from postproc.nc.cycles.drilling_fagor import FagorDrilling
from postproc.nc.cycles.drilling_fanuc import FanucDrilling, HaasDrilling, LatheDrilling
from postproc.nc.cycles.drilling_haas_lathe import HaasLatheDrilling
from postproc.nc.cycles.drilling_linuxcnc import LinuxcncDrilling
from postproc.nc.cycles.drilling_okuma import OkumaDrilling, ReturnLevel
from postproc.nc.cycles.drilling_okuma_lathe import LiveDrilling
from postproc.nc.cycles.engraving_haas import Engraving
from postproc.nc.cycles.frame_control import FrameControl
from postproc.nc.cycles.frames_fanuc import FanucFrames
from postproc.nc.cycles.frames_haas import HaasFrames
from postproc.nc.cycles.frames_siemens import SiemensFrames
from postproc.nc.cycles.grooving_fanuc import Grooving
from postproc.nc.cycles.grooving_okuma import OkumaGrooving
from postproc.nc.cycles.holes_heidenhain import IsoHoles
from postproc.nc.cycles.klartext_turns import KlartextTurns
from postproc.nc.cycles.nurbs_fanuc import FanucNurbs
from postproc.nc.cycles.pocket_haas import Pocket
from postproc.nc.cycles.pole_heidenhain import PoleArcs
from postproc.nc.cycles.polynomials_siemens import Polynomials
from postproc.nc.cycles.rotation_linuxcnc import LinuxcncRotation
from postproc.nc.cycles.scene import Scene
from postproc.nc.cycles.spline_marlin import MarlinSpline
from postproc.nc.cycles.splines import Splines
from postproc.nc.cycles.threading import LinuxcncThread
from postproc.nc.cycles.turning_fanuc import Repetitive
from postproc.nc.cycles.turning_linuxcnc import LinuxcncTurning
from postproc.nc.cycles.turning_single import Stays, Turn
from postproc.nc.dialects import Dialect


@dataclass(frozen=True)
class Family:
    """The cycles of a dialect by ten times their G number, and its frames. `restores`: G80 brings
    back the motion code (G0 G1 G2 G3) that was in force before the cycle; `forgets`: it is unknown
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


def _by_code(*cycles: Cycle) -> dict[int, Cycle]:
    return {code: cycle for cycle in cycles for code in cycle.codes}


def _haas(synchronised: bool) -> Family:
    drilling = HaasDrilling(synchronised)

    # The bolt circle calls the cycle in force, so it must ask the same object that `cycles` has; a
    # class of its own carries it, since parts are made from the scene alone.
    class Bolts(BoltHoles):
        holes = drilling

    cycles = _by_code(drilling, CircularPocket(), Engraving(), Pocket())
    return Family(cycles, HaasFrames, restores=True, parts=(Bolts, FanucCorners))


# Columns: finish, rough along Z, rough along X, repeat the shape, peck along Z, groove along X,
# thread, and the box cycles of one block: turn, thread, face.
SYSTEMS = {  # G70 to G76 and G90 G92 G94, as the three G-code systems of a Fanuc lathe have them
    "a": (700, 710, 720, 730, 740, 750, 760, 900, 920, 940),
    "b": (700, 710, 720, 730, 740, 750, 760, 770, 780, 790),
    "c": (720, 730, 740, 750, 760, 770, 780, 200, 210, 240),
}


def _lathe(holes: Cycle, system: str, haas: bool = False) -> Family:
    finish, rough, face, repeat, peck, groove, thread, turn, single, end = SYSTEMS[system]
    roles = {finish: "finish", rough: "rough", face: "face", repeat: "repeat"}
    cycles = _by_code(
        holes,
        Repetitive(roles, haas),
        Grooving((peck,), "Z", haas),
        Grooving((groove,), "X", haas),
        Stays((thread,), False),
        Turn((turn,), False, haas),
        Stays((single,), True),
        Turn((end,), True, haas),
    )
    return Family(cycles, restores=True, parts=(FanucCorners,))


def _okuma(synchronised: bool) -> Family:
    holes = OkumaDrilling(synchronised)
    return Family(_by_code(holes, ReturnLevel(holes)), forgets=True)


def _okuma_lathe(synchronised: bool) -> Family:
    threads = Stays((310, 320, 330), True), Stays((710, 720, 770, 780), False)
    grooves = OkumaGrooving((730,), "X"), OkumaGrooving((740,), "Z")
    cycles = _by_code(*threads, *grooves, LiveDrilling())
    return Family(cycles, forgets=True, parts=(LatheBlocks, FanucCorners))


# In this order: AR= has become I J before CT looks for the arc that it touches, whose centre it
# reads from I J K or CR alone.
SIEMENS = (BlockFeed, SiemensDirections, Openings, PlacedArcs, Polynomials)
# By the beginning of a dialect's name, the longest of which holds. On grblHAL holes and threads
# stay: they are not measured. On Haas lathes R of holes is a place, unlike on Fanuc's.
FAMILIES: dict[str, Callable[[bool], Family]] = {
    "linuxcnc": lambda s: Family(
        _by_code(LinuxcncDrilling(s), Splines(), LinuxcncThread(), LinuxcncTurning()),
        LinuxcncRotation,
    ),
    "grblhal": lambda s: Family(_by_code(Splines(nurbs=False))),
    "fanuc": lambda s: Family(
        _by_code(FanucDrilling(s), FanucNurbs()),
        FanucFrames,
        restores=True,
        parts=(FanucCorners, ToolDirections),
    ),
    "fanuc-lathe": lambda s: _lathe(LatheDrilling(s), "b"),
    "fanuc-lathe-a": lambda s: _lathe(LatheDrilling(s), "a"),
    "fanuc-lathe-c": lambda s: _lathe(LatheDrilling(s), "c"),
    "siemens": lambda s: Family(control=SiemensFrames, parts=SIEMENS),
    "marlin": lambda s: Family(_by_code(MarlinSpline())),
    "heidenhain": lambda s: Family(parts=(KlartextTurns,)),
    "heidenhain-iso": lambda s: Family(parts=(IsoCorners, IsoHoles, PoleArcs)),
    "haas": _haas,
    "haas-lathe": lambda s: _lathe(HaasLatheDrilling(s), "a", haas=True),
    "fadal": lambda s: Family(_by_code(FadalDrilling(s)), restores=True),
    "fagor": lambda s: Family(_by_code(FagorDrilling(s)), forgets=True, until_g80=True),
    "okuma": _okuma,
    "okuma-lathe": _okuma_lathe,
}


def family(dialect: Dialect, synchronised: bool = False) -> Family:
    """The cycles and frames of a dialect; none where they are not written."""
    # "fanuc-lathe-a" begins with "fanuc" too: the longest beginning is the nearest kin.
    found = max((p for p in FAMILIES if dialect.name.startswith(p)), key=len, default="")
    if not found:
        return Family()
    every = FAMILIES[found](synchronised)
    # A kin that lacks a code (PathPilot of LinuxCNC) shall refuse it as unknown, as its control
    # does.
    known = {code_number(code.word) for code in dialect.codes}
    return replace(every, cycles={n: cycle for n, cycle in every.cycles.items() if n in known})
