"""How well the map is known, by drawing machines: quadrature, spread of the drawn tips, and the
share that the stated U holds, on exact transforms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pytest import approx

from postproc.errors import MachineError
from postproc.machine.axis import Axis
from postproc.machine.chain import ROTARY, XYZ, parse
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable, AxisUncertainty
from postproc.machine.uncertainty import MapUncertainty
from tests.reference.kinematics import Link, tip
from tests.reference.test_chains import BETWEEN, FIVE_AXIS, LINEAR, along_slides

DRAWS = 400


def uncertain_machine(rng, chain_text: str):
    """A machine whose errors are zero and whose uncertainties are flat, and the U of everything by
    axis and row."""
    chain = parse(chain_text)
    axes, square_u, sizes, links = {}, {}, {}, []
    for x in sorted(chain.axes, key=(XYZ + ROTARY).index):
        linear = x in XYZ
        own = (XYZ if linear else ROTARY).index(x)
        u = np.concatenate([rng.uniform(0.001, 0.005, 3), rng.uniform(1e-6, 3e-5, 3)])
        lean = np.where(np.arange(3) == own, 0.0, rng.uniform(1e-6, 2e-5, 3))
        square_u |= {f"{ROTARY[i]}0{x}": float(lean[i]) for i in range(3) if i != own}
        both = np.repeat(u[:, None], 2, axis=1)
        table = AxisTable(x, np.array([-400.0, 400.0]), both, both)
        measured = rng.uniform(-200, 200, 3)
        centre = np.zeros(3) if linear else rng.uniform(-80, 80, 3)
        uncertainty = AxisUncertainty(table, tuple(range(6)))
        axes[x] = Axis(
            x, (-400.0, 400.0), 1e-4, measured, None, "", centre, uncertainty=uncertainty
        )
        sizes[x] = (u, lean)
        q = float(rng.uniform(-300, 300) if linear else rng.uniform(-60, 60))
        carried = chain.axes[chain.axes.index(x) + 1 :]  # where any other stood is no arm
        counts = np.where([y in carried for y in XYZ], measured, 0.0)
        links.append(Link(x, chain.side(x), q, measured=counts, centre=centre))
    links.sort(key=lambda link: chain.axes.index(link.letter))
    tool = rng.uniform(-150, 150, 3)
    return Machine("m", "", "linuxcnc", chain, axes, tool=tool, square_u=square_u), links, sizes


def placed(rng, chain: str):
    """A machine as above at a pose that can be corrected, its slides' directions (3, S), and U (S,)
    there."""
    while True:
        m, links, sizes = uncertain_machine(rng, chain)
        position = np.array([[link.q for link in links if link.letter == x] for x in m.letters])
        try:
            stated = MapUncertainty(m).expanded(position, np.zeros_like(position))[:, 0]
        except MachineError:
            assert chain in BETWEEN
            continue
        slides = [x for x in m.letters if x in XYZ]
        ways = [along_slides(m, links, np.eye(3)[XYZ.index(x)]) for x in slides]
        return m, links, sizes, np.stack(ways, axis=1), stated[[m.letters.index(x) for x in slides]]


@pytest.mark.parametrize("chain", LINEAR + FIVE_AXIS + BETWEEN)
def test_quadrature_of_exact_derivatives(chain):
    """Every error by itself: the tip's derivative by central difference of exact transforms, told
    along the slides."""
    m, links, sizes, ways, stated = placed(np.random.default_rng([6, *chain.encode()]), chain)
    square = np.zeros(len(stated))
    for k, link in enumerate(links):
        u, lean = sizes[link.letter]
        for row in np.diag(np.concatenate([u, lean])):
            one = [
                *links[:k],
                replace(link, d=row[:3], eps=row[3:6], lean=row[6:]),
                *links[k + 1 :],
            ]
            slope = (tip(one, m.tool, 1e-3) - tip(one, m.tool, -1e-3)) / 2e-3
            square += np.linalg.lstsq(ways, slope, rcond=None)[0] ** 2
    assert stated == approx(np.sqrt(square), rel=1e-6)


@pytest.mark.parametrize("chain", LINEAR + FIVE_AXIS + BETWEEN)
def test_drawn_machines_spread_as_stated(chain):
    """Every error normal with U / 2, the tip by exact transforms, told along the slides; 400 draws
    know a spread to 3.5 % (1 / sqrt(2 n)), and five times that is allowed."""
    rng = np.random.default_rng([5, *chain.encode()])
    m, links, sizes, ways, stated = placed(rng, chain)
    nominal = tip(links, m.tool, 0.0)
    drawn = np.zeros((DRAWS, len(stated)))
    for k in range(DRAWS):
        one = []
        for link in links:
            u, lean = sizes[link.letter]
            error = rng.normal(size=6) * u / 2
            one.append(
                replace(link, d=error[:3], eps=error[3:], lean=rng.normal(size=3) * lean / 2)
            )
        drawn[k] = np.linalg.lstsq(ways, tip(one, m.tool, 1.0) - nominal, rcond=None)[0]
    spread = 2 * drawn.std(axis=0)
    assert stated == approx(spread, rel=5 / np.sqrt(2 * DRAWS))


@pytest.mark.parametrize("along", ["alike", "each node by itself"])
def test_drawn_tables_spread_as_stated_between_their_nodes(along):
    """Errors that are alike along a table spread by U everywhere; where each node has its own, by U
    at the nodes and by less between: never more."""
    rng = np.random.default_rng(9)
    nodes = np.array([0.0, 40.0, 100.0])
    u = rng.uniform(0.001, 0.01, 3)
    full = np.zeros((6, 3))
    full[0] = u
    axis = Axis(
        "X",
        (0.0, 100.0),
        1e-4,
        np.zeros(3),
        uncertainty=AxisUncertainty(AxisTable("X", nodes, full, full), (0,)),
    )
    m = Machine("m", "", "linuxcnc", parse("w-X-b-t"), {"X": axis})
    at = np.linspace(0, 100, 21)[None]
    stated = MapUncertainty(m).expanded(at, np.zeros_like(at))[0]
    n = 20_000
    errors = rng.normal(size=(n, 1 if along == "alike" else 3)) * u / 2
    spread = 2 * np.std([np.interp(at[0], nodes, e) for e in errors], axis=0)
    if along == "alike":
        assert stated == approx(spread, rel=5 / np.sqrt(2 * n))
    else:
        assert stated[[0, 8, 20]] == approx(spread[[0, 8, 20]], rel=5 / np.sqrt(2 * n))
        assert (spread < stated * (1 + 5 / np.sqrt(2 * n))).all() and spread[4] < 0.8 * stated[4]


def test_the_length_covers_the_vector_in_95_of_100():
    """However few or many errors make it: one alone 95 %, several more."""
    rng = np.random.default_rng(4)
    for chain in ("w-X-Y-b-Z-t", "w-C-A-b-X-Y-Z-t"):
        m, links, _ = uncertain_machine(rng, chain)
        position = np.array([[link.q for link in links if link.letter == x] for x in m.letters])
        sure = MapUncertainty(m)
        parts = np.array(
            [p.deviation(position, np.zeros_like(position))[:, 0] for p in sure.parts.values()]
        )
        assert len(parts) == 6 * len(m.axes) + len(m.square_u)
        drawn = rng.normal(size=(20_000, len(parts))) / 2 @ parts
        inside = np.linalg.norm(drawn, axis=1) <= sure.length(position, np.zeros_like(position))[0]
        assert inside.mean() >= 0.95
