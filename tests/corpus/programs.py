"""The real programs beside the project, which are no part of it: each in the dialect that a knowing
user would choose, and why."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CORPUS = ROOT.parent / "shared" / "corpus"
FOLDERS = ("fanuc", "mixed", "sinumerik")
NO_PROGRAMS = {"LICENSE", "README.md"}
XYZ, ROTARY = "XYZ", "ABC"

PLOTTER = "a pen on a small controller: M300 lifts it, G4 P counts milliseconds"
LATHE = "X and Z alone, X a diameter, I K arcs in G18"
HELP = "for the eyes of a parser's tests, no program: pieces of many languages"
MIXED = {
    "_Insulpro.Piping.-.115mm.OD.-.40mm.WT.txt": (
        "linuxcnc",
        "plain DIN codes between % lines, no control of its own",
    ),
    "_cncwebsim_fresa.gcode": ("linuxcnc", "plain codes, `;` comments, G92 with axis words"),
    "_fresa.gcode": ("linuxcnc", "plain codes, `;` comments, G92 with axis words"),
    "_dxf2gcode_join.ngc": ("linuxcnc", "dxf2gcode, G64 P"),
    "_join.ngc": ("linuxcnc", "dxf2gcode, G64 P"),
    "_ffcp_end.gcode": (
        "marlin",
        "the end of a print (Sailfish, a printer's firmware): Marlin is its next of kin",
    ),
    "_gcodeLexer_samples.ngc": ("linuxcnc", HELP),
    "_samples.ngc": ("linuxcnc", HELP),
    "_gcodehs_sample.gcode": ("linuxcnc", "pcb2gcode writes for LinuxCNC"),
    "_libgcode_slot.ngc": ("linuxcnc", "O words: a library of subprograms"),
    "_slot.ngc": ("linuxcnc", "O words: a library of subprograms"),
    "_linuxcnc_dot.ngc": ("linuxcnc", "O words: a library of subprograms"),
    "_mach3.gcode": ("mach3", "says so; torch height by S words"),
    "_mach3_plasma.gcode": ("mach3", "says so; torch height by S words"),
    "_program_3.gcode": ("mach3", "Vectric's post for Mach3: G71, G91.1, M62 P1"),
    "_viaconstructor_simple.ngc": ("linuxcnc", "viaConstructor, G64 P"),
    "arc_end.gcode": ("marlin", "the end of a print: E, M104, M140, M84"),
    "bondtech_estep.gcode": ("marlin", "settings of a printer: M92 E, M500"),
    "circle_a.gcode": ("grbl", "Estlcam, plain codes: GRBL reads them"),
    "estlcam_circle_a.gcode": ("grbl", "Estlcam, plain codes: GRBL reads them"),
    "makerblock_tinycnc.gcode": ("marlin", PLOTTER),
    "plotter_owl.gcode": ("marlin", PLOTTER),
    "program_1.gcode": (
        "mach3",
        "O number of Fanuc, but `;` comments, which a Fanuc does not have",
    ),
    "program_2.gcode": (
        "linuxcnc",
        "`;` takes blocks out; G41 without D means the tool in the spindle",
    ),
    "reprap_25000_cnc.gcode": ("marlin", "for a RepRap's printer board: all feeds, arcs by R"),
    "reprap_cnc.gcode": ("marlin", "for a RepRap's printer board: all feeds, arcs by R"),
}
FRAGMENTS = {"mixed/_gcodeLexer_samples.ngc", "mixed/_samples.ngc"}
ABSOLUTE_CENTRES = {
    "fanuc/BOTTLE.NC",
    "fanuc/CONTOUR_ABS.NC",
    "fanuc/TEST2.NC",
}  # their user says --arc-centre absolute
SLOW = {
    "fanuc/BOTTLE.NC": 400,
    "fanuc/PARALLEL.NC": 400,
    "mixed/makerblock_tinycnc.gcode": 600,
}  # lines that tests read


@dataclass(frozen=True)
class Program:
    """One file. name: "folder/file"; dialect: the one that a knowing user would choose; why: where
    that is not obvious."""

    name: str
    path: Path
    dialect: str
    why: str = ""

    @property
    def text(self) -> bytes:
        return self.path.read_bytes()

    @property
    def short(self) -> bytes:
        """The text, of a long one its first lines."""
        return b"".join(self.text.splitlines(keepends=True)[: SLOW.get(self.name, 10**9)])

    @property
    def lathe(self) -> bool:
        """Whether its user has a lathe: slides X and Z, X a diameter."""
        return "lathe" in self.dialect

    @property
    def arc_centre(self) -> str:
        return "absolute" if self.name in ABSOLUTE_CENTRES else "incremental"


def programs() -> list[Program]:
    """All programs, in order of folder and name; none where the corpus is not there."""
    found = []
    for folder in FOLDERS:
        for path in sorted((CORPUS / folder).glob("*"), key=lambda p: p.name):
            if path.suffix == ".csv" or path.name in NO_PROGRAMS:
                continue
            found.append(Program(f"{folder}/{path.name}", path, *chosen(folder, path.name)))
    return found


def has_cycles(program: Program) -> bool:
    """Whether canned cycles or frames stand in it, which --expand writes out though they can be
    corrected in place."""
    return bool(re.search(rb"(?i)G8[1-9]|G7[346]|TRANS|ROT|DEF |=|o<", program.text))


def chosen(folder: str, name: str) -> tuple[str, str]:
    """Dialect, and why."""
    if folder == "sinumerik":
        return "siemens", ""
    if folder == "fanuc":
        return ("fanuc-lathe", LATHE) if "TURN" in name else ("fanuc-mill", "")
    return MIXED.get(name, ("linuxcnc", "not looked at yet"))


def recognised(text: bytes) -> str:
    """What `--dialect auto` takes it for; several names where the signs are the same."""
    try:
        from postproc.nc.recognise import recognise
    except ImportError:
        return "?"
    found = recognise(text)
    if not found:
        return ""
    return " ".join(name for name, signs in found if len(signs) == len(found[0][1]))
