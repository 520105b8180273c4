"""Where the other axes stood: a map from 18 recordings without noise is as good as its targets
allow, wherever they were taken; and so is a squareness that a square gave at any place."""

from __future__ import annotations

import zlib
from dataclasses import replace

import numpy as np
import pytest
from pytest import approx

from postproc.calibrate import Options, opening
from postproc.calibrate.run import calibrate
from postproc.machine.axis import Axis
from postproc.machine.chain import XYZ, parse
from postproc.machine.model import Machine
from postproc.machine.stated import Limits
from postproc.machine.tables import COMPONENTS, AxisTable
from postproc.recordings import Recording

UM, URAD = 1e-3, 1e-6
TRAVEL = {"X": (0.0, 500.0), "Y": (0.0, 400.0), "Z": (-300.0, 0.0)}
CHAINS = ("w-X-Y-b-Z-t", "w-b-X-Y-Z-t", "w-Y-b-X-Z-t", "w-X-b-Z-Y-t")
SQUARE = ("C0Y", "A0Z", "B0Z")
TARGETS = 11
LIMIT = 1.2  # times the error that linear interpolation between true values makes


def wave(rng, t: np.ndarray, size: float) -> np.ndarray:
    return sum(
        size / (k + 1) * np.sin(np.pi * (k + 1) * t * rng.uniform(0.7, 1.3) + rng.uniform(0, 6))
        for k in range(3)
    )


def truth(rng, chain) -> Machine:
    """All 18 components, 8 um and 15 urad, on 401 nodes each, and axes 100 urad out of square."""
    axes, t = {}, np.linspace(0, 1, 401)
    for x in XYZ:
        values = np.stack(
            [wave(rng, t, 8.0) * UM for _ in range(3)]
            + [wave(rng, t, 15.0) * URAD for _ in range(3)]
        )
        table = AxisTable(x, TRAVEL[x][0] + t * np.ptp(TRAVEL[x]), values, values, tuple(range(6)))
        axes[x] = Axis(x, TRAVEL[x], 1e-4, np.zeros(3), table)
    a, b, c = rng.normal(0, 100, 3) * URAD
    square = {"Y": np.array([0.0, 0.0, c]), "Z": np.array([a, b, 0.0])}
    return Machine(
        "", "", "", chain, axes, limits=Limits(outside="clamp"), square=square, square_stated=SQUARE
    )


def recording(machine: Machine, letter: str, row: int, rest: dict[str, float]) -> Recording:
    """One component without noise, the other axes at `rest`; straightnesses of a pair against one
    square."""
    q = np.linspace(*TRAVEL[letter], TARGETS)
    place = np.stack([q if x == letter else np.full(TARGETS, rest[x]) for x in machine.letters])
    columns = {f"{x}_mm": place[i] for i, x in enumerate(machine.letters)}
    columns |= {
        "run": np.ones(TARGETS),
        "t_s": 1.0 * np.arange(TARGETS),
        f"approach_{letter}": np.ones(TARGETS),
    }
    head = {"sensitive": {XYZ[row % 3]: 1.0}, "quantity": "displacement", "u_um": 0.01}
    if row > 2:
        table = machine.axes[letter].table
        columns["reading_urad"] = np.interp(q, table.nodes, table.forward[row]) / URAD
        head["quantity"] = "angle"
    else:
        columns["reading_um"] = (
            machine.deviation(place, np.zeros_like(place))[machine.letters.index(XYZ[row])] / UM
        )
    if row < 3 and XYZ[row] != letter:
        head |= {
            "quantity": "straightness",
            "reference": f"square {''.join(sorted(XYZ[row] + letter))}",
        }
    return Recording("targets", head, columns, f"{COMPONENTS[row]}{letter}.csv", np.arange(TARGETS))


def rests(how: str, name: str) -> dict[str, float]:
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    middle = {"X": 240.0, "Y": 210.0, "Z": -170.0}
    return {
        "zero": dict.fromkeys(XYZ, 0.0),
        "middle": middle,
        "scattered": {x: round(rng.uniform(*TRAVEL[x])) * 1.0 for x in XYZ},
    }[how]


def measured(machine: Machine, how: str, without: tuple[str, ...] = ()) -> list[Recording]:
    names = [(x, row) for x in XYZ for row in range(6) if f"{COMPONENTS[row]}{x}" not in without]
    return [recording(machine, x, row, rests(how, f"{x}{row}")) for x, row in names]


def apart(one: Machine, other: Machine) -> float:
    """um: rms over the volume of the difference, without the six motions of a rigid body, which
    nobody sees."""
    place = np.stack(
        [g.ravel() for g in np.meshgrid(*(np.linspace(*TRAVEL[x], 15) for x in XYZ), indexing="ij")]
    )
    still = np.zeros_like(place)
    y = (one.deviation(place, still) - other.deviation(place, still)).ravel()
    terms = [np.repeat(np.eye(3)[k], place.shape[1]) for k in range(3)]
    terms += [np.cross(np.eye(3)[k][:, None], place, axis=0).ravel() for k in range(3)]
    left = y - np.stack(terms, 1) @ np.linalg.lstsq(np.stack(terms, 1), y, rcond=None)[0]
    return float(np.sqrt((left.reshape(3, -1) ** 2).sum(axis=0).mean())) / UM


def sampled(machine: Machine) -> Machine:
    """The machine with the targets as nodes: what linear interpolation alone costs."""
    axes = {}
    for x, axis in machine.axes.items():
        q = np.linspace(*TRAVEL[x], TARGETS)
        values = np.stack([np.interp(q, axis.table.nodes, row) for row in axis.table.forward])
        axes[x] = replace(axis, table=AxisTable(x, q, values, values, axis.table.stated))
    return replace(machine, axes=axes)


def made(calibration) -> Machine:
    square: dict[str, np.ndarray] = {}
    for one in calibration.squareness.values():
        square.setdefault(one.name[2], np.zeros(3))["ABC".index(one.name[0])] = one.value
    return replace(calibration.machine, square=square, limits=Limits(outside="clamp"))


@pytest.mark.parametrize("chain", CHAINS)
@pytest.mark.parametrize("how", ["zero", "middle", "scattered"])
@pytest.mark.parametrize("line", ["least-squares", "end-points"])
def test_eighteen_recordings_give_the_machine_wherever_they_were_taken(chain, how, line):
    """Squareness read where angles have turned the axes was 3.0 to 8.2 times the error of
    interpolation."""
    for seed in range(3):
        machine = truth(np.random.default_rng(seed), parse(chain))
        options = Options(parse(chain), keep_all=True, square_error=(0.0, 1e-9), line=line)
        found = calibrate(measured(machine, how), options)
        assert set(found.squareness) == set(SQUARE)
        assert apart(made(found), machine) < LIMIT * apart(sampled(machine), machine), (
            seed,
            found.squareness,
        )


@pytest.mark.parametrize("chain", CHAINS)
def test_a_stated_squareness_holds_where_the_square_stood(chain):
    """What a square shows at X 310, Y 90, Z -220 is the slopes of both its arms there; brought to
    the tables' zero it makes the same machine."""
    machine = truth(np.random.default_rng(5), parse(chain))
    at = {"X": 310.0, "Y": 90.0, "Z": -220.0}
    on_it = [recording(machine, x, XYZ.index(o), at) for x in XYZ for o in XYZ if x != o]
    parts = {r.file[:3]: r for r in on_it}
    stated = {}
    for name, (a, b) in {"C0Y": "XY", "A0Z": "YZ", "B0Z": "XZ"}.items():
        slopes = [
            np.polyfit(parts[f"E{o}{m}"].position(m), parts[f"E{o}{m}"].reading, 1)[0]
            for m, o in ((a, b), (b, a))
        ]
        # the signs of chain.leans
        stated[name] = ((1 if name == "B0Z" else -1) * sum(slopes), 1e-9)
    found = calibrate(
        measured(machine, "scattered"),
        Options(parse(chain), keep_all=True, squareness=stated, square_at=at),
    )
    assert apart(made(found), machine) < LIMIT * apart(sampled(machine), machine)
    without = calibrate(
        measured(machine, "scattered"), Options(parse(chain), keep_all=True, squareness=stated)
    )
    assert apart(made(without), machine) > 2 * apart(sampled(machine), machine)
    doubts = [f for f in without.findings if f.check == "square-at"]
    assert len(doubts) == 3 and all(
        "--square-at" in f.message and f.level == "doubt" for f in doubts
    )


def test_the_opening_by_hand():
    """w-b-Z-X-t, EBZ = 20 urad at Z 400 and 0 at Z 0: there X leans by 20 urad more, since Z
    carries it."""
    q = np.linspace(0.0, 400.0, 5)

    def along(letter, component, value, angle=False):
        columns = {
            f"{letter}_mm": q,
            "XZ".replace(letter, "") + "_mm": np.zeros(5),
            "run": np.ones(5),
            "t_s": q,
        }
        columns |= {
            f"approach_{letter}": np.ones(5),
            "reading_urad" if angle else "reading_um": value,
        }
        quantity = "angle" if angle else "displacement"
        head = {"quantity": quantity, "sensitive": {component: 1.0}, "u_um": 0.01}
        return Recording("targets", head, columns, f"{letter}{quantity}.csv", np.arange(5))

    parts = [along("Z", "Z", q * 0.01), along("X", "X", q * 0.01), along("Z", "Y", q * 0.05, True)]
    found = calibrate(
        parts,
        Options(parse("w-b-Z-X-t"), squareness={"B0X": (100 * URAD, 1e-9)}, square_at={"Z": 400.0}),
    )
    assert opening.opened(found, "B0X", {"Z": 400.0}) == approx(20 * URAD, abs=1e-12)
    assert opening.opened(found, "B0X", {"Z": 0.0, "X": 300.0}) == approx(0.0, abs=1e-12)
    assert found.squareness["B0X"].value == approx(80 * URAD, abs=1e-12)
    assert "the axes' own angles make +20.0 of it" in found.squareness["B0X"].remark
