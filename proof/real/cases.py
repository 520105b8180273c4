"""The recordings: from whom, by what licence, what its authors say, how the effect is concealed,
what the right answer is.

`right` holds the names of what the authors say and the model is without; where nobody says a
number, an arithmetic of two lines that is not the tool's stands for it (checks.py). Of the ecmc
reports it held the reversal alone before the first run; the mean deviation, which the same authors
print, was added when the tool had named it.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from proof.real import checks, convert
from proof.seed import experiment

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
DATA = HERE / "data"
SHARED = Path(os.environ.get("GCOMP_RECORDINGS", ROOT.parent / "shared" / "recordings"))

ECMC = "A. Sandstrom, ecmccfg (Paul Scherrer Institut and ESS)"
ECMC_FILE = "github.com/paulscherrerinstitute/ecmccfg, examples"
GPL = "GPL-3.0-or-later, stored"
SLIT_SOURCE = (
    "linear_1.ax of the same example: open loop stepper, 5 mm/s, soft limits -50 and 80 mm;"
    " reference re-scaled by its authors"
)
THESIS = "M. Asad Ullah, MS thesis, NUST Islamabad 2013"
SERVO = "B. Kotov, A Low-Cost Platform for Measuring Backlash in Popular UART Servos, Robonine 2025"
MICHIGAN = "System-level Manufacturing and Automation Research Testbed, University of Michigan 2018"
EMPS = "A. Janot, M. Gautier, M. Brunot, EMPS, Nonlinear System Identification Benchmarks 2019"


@dataclass(frozen=True)
class Job:
    """Files that the command line gets."""

    recordings: list[Path]
    machine: Path
    options: tuple[str, ...] = ()


@dataclass(frozen=True)
class Case:
    name: str
    title: str
    whom: str
    licence: str
    known: str
    concealed: str
    right: frozenset[str]  # effect:axis; none: nothing is left out
    make: Callable[[Path], Job | None]
    check: Callable[[checks.Outcome], checks.Check] | None = None
    quick: bool = True
    all_of: frozenset[str] = frozenset()  # names that must be there, first or not
    note: str = ""


def put(folder: Path, files: dict[str, str]) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def text(name: str) -> str:
    return (DATA / name).read_text(encoding="utf-8")


def ecmc(name: str, travel: tuple[float, float], u_um: float) -> Callable[[Path], Job]:
    def make(folder: Path) -> Job:
        machine = convert.bare(
            "slit", "One linear axis", SLIT_SOURCE, {"X": travel}, "w-b-X-t", "linuxcnc"
        )
        source = f"{ECMC}, {ECMC_FILE}"
        report = convert.iso_report(
            text(f"{name}.md"), "slit", "external reference sensor", source, u_um
        )
        return Job(
            [put(folder, {f"{name}.csv": report}) / f"{name}.csv"], put(folder / "slit", machine)
        )

    return make


def chamber(folder: Path) -> Job:
    source = "N. Bade, TUHH, PythonChamberApp, docs/MovementAccuracy"
    machine = convert.bare(
        "chamber",
        "Bed of a measurement chamber",
        source,
        {"Z": (0.0, 900.0)},
        "w-Z-b-t",
        "linuxcnc",
    )
    recording = put(folder, {"z.csv": convert.dial_gauge(text("chamber_z.csv"), source)}) / "z.csv"
    return Job([recording], put(folder / "chamber", machine), ("--holdout", "run=3"))


def servo(loaded: bool) -> Callable[[Path], Job]:
    def make(folder: Path) -> Job:
        machine = convert.bare(
            "sts3215",
            "Servo with a lever of 100 mm, arc at its tip",
            SERVO,
            {"X": (0.0, 629.0)},
            "w-b-X-t",
            "linuxcnc",
        )
        recording = convert.servo_rests(text("sts3215_single.csv"), SERVO, loaded)
        return Job(
            [put(folder, {"rests.csv": recording}) / "rests.csv"], put(folder / "sts3215", machine)
        )

    return make


def studer(axis: str, complete: bool = False) -> Callable[[Path], Job]:
    def make(folder: Path) -> Job:
        name = f"{axis.lower()}_positioning"
        paths = experiment.write(folder / "tables")
        machine = ROOT / "machines" / "studer-s36"
        if not complete:
            machine = put(folder / "studer-without-lost-motion", convert.concealed(machine, axis))
        return Job([paths[name]], machine)

    return make


def parts(folder: Path) -> Job:
    return Job([experiment.write(folder / "tables")["parts"]], experiment.MACHINES["mill"])


def renumbered(source: Path, target: Path, run: Callable[[float], int]) -> Path:
    """The same recording with other numbers of runs, so that one of them can be held out."""
    lines = source.read_text(encoding="utf-8").splitlines()
    first = next(i for i, line in enumerate(lines) if not line.startswith("# "))
    rows = [line.split(",", 2) for line in lines[first + 1 :]]
    lines[first + 1 :] = [f"{run(float(t))},{t},{rest}" for _, t, rest in rows]
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return target


def michigan(folder: Path, number: int = 6) -> Job | None:
    """The first so many of the logs; the one behind their middle takes no part in the fit."""
    files = sorted(SHARED.glob("umich_mill_*.csv"))[:number]
    if not files:
        return None
    files = [renumbered(p, folder / p.name, lambda t, k=k: k) for k, p in enumerate(files, 1)]
    held = ("--holdout", f"run={number // 2 + 1}")
    return Job(files, ROOT / "machines" / "perfect", held)


def feed_drive(folder: Path) -> Job | None:
    source = SHARED / "feed_drive_1.csv"
    if not source.exists():
        return None
    cut = renumbered(source, folder / source.name, lambda t: 1 + int(t // 5))
    return Job([cut], ROOT / "machines" / "perfect", ("--holdout", "run=3"))


CASES = [
    Case(
        "ecmc-1050",
        "Linear axis of MCU1025, acceptance test by ISO 230-2, 10:50",
        ECMC,
        GPL,
        "reversal error at the five targets 6.2, -27.3, -5.7, 21.7, 46.5 um (forward - backward),"
        " mean deviation 36 um",
        "a machine without tables",
        frozenset({"backlash_position:X", "pitch_shape:X"}),
        ecmc("ecmc_mcu1025_1050", (15.0, 55.8), 0.2),
        checks.reversal_at(
            [15.0, 25.2, 35.4, 45.6, 55.8], [6.24, -27.28, -5.67, 21.69, 46.49], 3.0
        ),
        all_of=frozenset({"backlash_position:X"}),
    ),
    Case(
        "ecmc-1345",
        "The same axis, measured again at 13:45",
        ECMC,
        GPL,
        "reversal error 10.8, -21.0, -9.9, 12.6, 43.5 um, mean deviation 48 um",
        "a machine without tables",
        frozenset({"backlash_position:X", "pitch_shape:X"}),
        ecmc("ecmc_mcu1025_1345", (15.0, 55.8), 0.2),
        checks.reversal_at(
            [15.0, 25.2, 35.4, 45.6, 55.8], [10.79, -21.02, -9.9, 12.59, 43.46], 3.0
        ),
        all_of=frozenset({"backlash_position:X"}),
    ),
    Case(
        "ecmc-1345-travel",
        "The same, the machine with the travel of its configuration, -50 to 80 mm",
        ECMC,
        GPL,
        "as above; nobody measured beyond 15 and 55.8 mm",
        "a machine without tables",
        frozenset({"backlash_position:X", "pitch_shape:X"}),
        ecmc("ecmc_mcu1025_1345", (-50.0, 80.0), 0.2),
        checks.within_readings("X", (-50.0, 80.0)),
        note=(
            "the curves are polynomials over the travel of the machine's file; the figure before is"
            " of a zero that was fitted together with them"
        ),
    ),
    Case(
        "ecmc-null",
        "Closed loop axis M1 on its own encoder",
        ECMC,
        GPL,
        "reversal error 0.012 um at most, all readings within 0.14 um of the target",
        "nothing: the null",
        frozenset(),
        ecmc("ecmc_psi", (-10.0, 10.48), 0.005),
    ),
    Case(
        "chamber-z",
        "Bed of an antenna measurement chamber, dial gauge, down, up and down",
        "N. Bade, TUHH, PythonChamberApp",
        "GPL-3.0, stored",
        "going up follows about 0.02 mm late, going down as well: decouplers and screw",
        "a machine without lost motion",
        frozenset({"backlash:Z", "windup:Z"}),
        chamber,
        checks.lost_motion_of_chamber,
        note="the authors' 0.02 mm lies outside the interval; the mean of their table does not",
    ),
    Case(
        "servo-rest",
        "STS3215 servo, rests without load, arc at 100 mm",
        SERVO,
        "CC BY 4.0 (its README), rests stored",
        "unloaded backlash 7.03 counts, 1.08 mm; after a command 11 counts, 1.69 mm, as its log"
        " shows",
        "a machine without lost motion",
        frozenset({"backlash:X", "backlash_position:X"}),
        servo(False),
        checks.servo,
        note=(
            "rests after a command and after a pull are one name; what they differ by is unknown"
        ),
    ),
    Case(
        "servo-load",
        "The same servo, with the pulls of the elastic bands",
        SERVO,
        "CC BY 4.0 (its README), rests stored",
        "14.78 counts, 2.26 mm, between the pulls to either side",
        "a machine without lost motion and compliance",
        frozenset({"force_compliance:X", "backlash:X", "backlash_position:X"}),
        servo(True),
        # between 7 counts without a pull and 14.78 with one
        checks.within("backlash:X", "size_um", 1080.0, 2260.0, "um"),
        note=("the pulls push the shaft through its play; rests of three kinds, one size"),
    ),
    Case(
        "studer-x",
        "Cylindrical grinder Studer S-36, positioning of X",
        THESIS,
        "tables of the thesis (see SEED_STORY)",
        "forward - reverse 8.2 to 9.9 um up to 130 mm, then 2.2, -1.9, 0.5, 1.5 um (Table 6.2)",
        "machines/studer-s36 with the mean of both directions of X in its table",
        frozenset({"backlash_position:X"}),
        studer("X"),
        checks.reversal_of_table("X", 1.0),
    ),
    Case(
        "studer-z",
        "The same, positioning of Z",
        THESIS,
        "tables of the thesis (see SEED_STORY)",
        "forward - reverse -1.3 to 5.1 and back to -3.3 um (Table 6.1)",
        "machines/studer-s36 with the mean of both directions of Z in its table",
        frozenset({"backlash_position:Z"}),
        studer("Z"),
        checks.reversal_of_table("Z", 1.0),
    ),
    Case(
        "studer-null",
        "The same reading of X, the machine complete",
        THESIS,
        "tables of the thesis (see SEED_STORY)",
        "the table is the reading: nothing can be left",
        "nothing: the null",
        frozenset(),
        studer("X", complete=True),
    ),
    Case(
        "mv1060-parts",
        "Two parts of a machining centre, coordinate measuring machine",
        THESIS,
        "tables of the thesis (see SEED_STORY)",
        'pockets too large, boss too small: "tool was little oversized"; by hand 80 to 140 um',
        "a tool of nominal size",
        frozenset({"tool_size:"}),
        parts,
        checks.within("tool_size:", "diameter_um", 80.0, 140.0, "um"),
    ),
    Case(
        "michigan",
        "Three-axis mill, six logs of its controller, 10 Hz, three digits",
        MICHIGAN,
        "CC0, not stored here",
        "command and actual position; of the lag the authors say nothing: in steady motion it is"
        " 8.1 ms (Y) and 8.3 ms (Z) by division",
        "a machine that follows at once",
        frozenset({"servo_lag:X", "servo_lag:Y", "servo_lag:Z"}),
        michigan,
        checks.steady_lag,
        quick=False,
        all_of=frozenset({"servo_lag:X", "servo_lag:Y", "servo_lag:Z"}),
        note="friction of currents is not written into a machine: it is named again",
    ),
    Case(
        "feed-drive",
        "Ball-screw slide, motor encoder, drive voltage, 1 kHz",
        EMPS,
        "not stated: cited, not stored",
        "mass 95.1 kg, viscous 203.5 N s/m, dry 20.4 N; of its loop, by the drive voltage: lag"
        " 6.40 ms",
        "a machine that follows at once, without friction",
        frozenset({"servo_lag:X", "viscous_friction:X", "coulomb_friction:X"}),
        feed_drive,
        checks.feed_drive,
        quick=False,
        all_of=frozenset({"servo_lag:X", "viscous_friction:X", "coulomb_friction:X"}),
        note=(
            "friction of forces is not written into a machine, so it is named again;"
            " the intervals of lag, viscous and dry friction miss what is known by 3, 6 and 6 %:"
            " the step by dry friction has no name of its own and is in the lag"
        ),
    ),
]
