"""Every chain against exact homogeneous transforms: the terms of first order to 1e-9 mm, the rest
within its bound."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from postproc.errors import MachineError
from postproc.machine.axis import Axis
from postproc.machine.chain import ROTARY, XYZ, parse
from postproc.machine.model import Machine
from postproc.machine.tables import AxisTable
from tests.reference.kinematics import Link, tip

ORDERS = list(itertools.permutations("XYZ"))
LINEAR = [
    "-".join(["w", *order[:bed], "b", *order[bed:], "t"]) for order in ORDERS for bed in range(4)
]
FIVE_AXIS = [
    "w-C-A-b-X-Y-Z-t",
    "w-C-B-b-Y-X-Z-t",
    "w-C-A-Y-b-X-Z-t",
    "w-X-Y-b-Z-C-B-t",
    "w-b-X-Y-Z-C-A-t",
    "w-C-X-b-Y-Z-B-t",
    "w-B-b-Z-X-t",
    "w-b-Z-X-B-t",
    "w-A-b-X-Y-Z-t",
    "w-C-Z-b-X-Y-A-t",
    "w-C-b-X-Z-t",
]
BETWEEN = ["w-X-B-b-Y-Z-t", "w-b-X-B-Y-Z-t", "w-C-Y-A-b-X-Z-t", "w-X-A-C-b-Y-Z-t"]


def random_machine(rng, chain_text, scale=1.0):
    """A machine whose tables are flat, so that its errors at a pose are plain numbers, and the
    links of the same."""
    chain = parse(chain_text)
    axes, square, links = {}, {}, []
    tool = rng.uniform(-150, 150, 3)
    for letter in sorted(chain.axes, key=(XYZ + ROTARY).index):
        errors = np.concatenate([rng.uniform(-0.05, 0.05, 3), rng.uniform(-60e-6, 60e-6, 3)])
        linear = letter in XYZ
        own = (XYZ if linear else ROTARY).index(letter)
        lean = rng.uniform(-100e-6, 100e-6, 3)
        lean[own] = 0.0
        shift = np.zeros(3) if linear else rng.uniform(-0.03, 0.03, 3)
        shift[own] = 0.0
        centre = np.zeros(3) if linear else rng.uniform(-80, 80, 3)
        measured = rng.uniform(-200, 200, 3)
        optic = str(rng.choice(["", "tool", "workpiece"])) if linear else ""
        nodes = np.array([-400.0, 400.0])
        table = AxisTable(
            letter,
            nodes,
            np.repeat(scale * errors[:, None], 2, axis=1),
            np.repeat(scale * errors[:, None], 2, axis=1),
        )
        location = np.concatenate([scale * shift, np.zeros(3)])
        axes[letter] = Axis(letter, (-400.0, 400.0), 1e-4, measured, table, optic, centre, location)
        square[letter] = scale * lean
        q = float(rng.uniform(-300, 300) if linear else rng.uniform(-170, 170))
        carried = chain.axes[chain.axes.index(letter) + 1 :]  # where any other stood is no arm
        counts = np.where([x in carried for x in XYZ], measured, 0.0)
        links.append(
            Link(
                letter,
                chain.side(letter),
                q,
                errors[:3],
                errors[3:],
                shift,
                lean,
                counts,
                centre,
                optic,
            )
        )
    links.sort(key=lambda link: chain.axes.index(link.letter))
    return Machine("m", "", "linuxcnc", chain, axes, square=square, tool=tool), links


def along_slides(machine, links, moves):
    """(3,) mm: how far the nominal tip goes when every slide goes by its part of `moves`."""
    gone = np.zeros(3)
    for link in links:
        if link.letter in XYZ:
            there = [replace(x, q=x.q + 1.0) if x.letter == link.letter else x for x in links]
            gone += (tip(there, machine.tool, 0.0) - tip(links, machine.tool, 0.0)) * moves[
                XYZ.index(link.letter)
            ]
    return gone


def predicted(machine, links):
    """(3,) mm: the machine's own deviation, X Y Z."""
    q = {link.letter: link.q for link in links}
    position = np.array([[q[x]] for x in machine.letters])
    result = np.zeros(3)
    for i, x in enumerate(machine.letters):
        if x in XYZ:
            result[XYZ.index(x)] = machine.deviation(position, np.zeros_like(position))[i, 0]
    return result


@pytest.mark.parametrize("chain", LINEAR + FIVE_AXIS + BETWEEN)
def test_first_order_terms_are_those_of_the_transforms(chain):
    """The exact deviation's derivative by the size of all errors, central difference: what is left
    of it is of third order, (1e-3)^2 of 1e-7 mm."""
    rng = np.random.default_rng(list(chain.encode()))
    done = 0
    while done < 6:
        machine, links = random_machine(rng, chain)
        slope = (tip(links, machine.tool, 1e-3) - tip(links, machine.tool, -1e-3)) / 2e-3
        try:
            moves = predicted(machine, links)
        except MachineError:
            assert chain in BETWEEN
            continue
        done += 1
        if all(x in machine.letters for x in XYZ):
            assert along_slides(machine, links, moves) == pytest.approx(slope, abs=1e-9)
        else:  # what no slide can reach is left: the rest stands across all of them
            rest = slope - along_slides(machine, links, moves)
            for x in (x for x in machine.letters if x in XYZ):
                assert rest @ along_slides(
                    machine, links, np.eye(3)[XYZ.index(x)]
                ) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("chain", LINEAR + FIVE_AXIS)
def test_what_is_left_out_is_within_the_stated_bound(chain):
    rng = np.random.default_rng([7, *chain.encode()])
    for _ in range(6):
        machine, links = random_machine(rng, chain)
        exact = tip(links, machine.tool, 1.0) - tip(links, machine.tool, 0.0)
        slope = (tip(links, machine.tool, 1e-3) - tip(links, machine.tool, -1e-3)) / 2e-3
        left = float(np.linalg.norm(exact - slope))
        assert left <= machine.bounds.second_order
        half = tip(links, machine.tool, 0.5) - tip(links, machine.tool, 0.0)
        assert np.linalg.norm(half - slope / 2) <= 0.3 * left + 1e-9, "not of second order"


def test_the_bound_is_of_the_size_of_what_is_left_out():
    """A bound for the whole travel of +-400 mm and the worst signs: within some hundred times what
    a random pose leaves."""
    rng = np.random.default_rng(3)
    ratios = []
    for _ in range(50):
        machine, links = random_machine(rng, "w-X-Y-b-Z-t")
        exact = tip(links, machine.tool, 1.0) - tip(links, machine.tool, 0.0)
        slope = (tip(links, machine.tool, 1e-3) - tip(links, machine.tool, -1e-3)) / 2e-3
        ratios.append(machine.bounds.second_order / np.linalg.norm(exact - slope))
    assert 1 <= min(ratios) and np.median(ratios) < 200


def test_a_table_that_turns_the_part_by_ninety_degrees_swaps_the_slides():
    """w-C-b-X-Y-Z-t at C = 90: the tip is off by +10 um in the part's X. C turns the tool relative
    to the part from X to Y, so the part's X lies along the machine's -Y: the slide Y seems to be
    off by -10 um."""
    chain = parse("w-C-b-X-Y-Z-t")
    flat = np.repeat(np.array([[0.0], [0.0], [0.0], [0.0], [0.0], [0.0]]), 2, axis=1)
    by_x = flat.copy()
    by_x[1] = 0.010  # EYX: X carries the tool too far along the machine's Y
    nodes = np.array([-400.0, 400.0])
    axes = {
        x: Axis(
            x,
            (-400, 400),
            1e-4,
            np.zeros(3),
            AxisTable(x, nodes, by_x if x == "X" else flat, by_x if x == "X" else flat),
        )
        for x in "XYZC"
    }
    machine = Machine("m", "", "linuxcnc", chain, axes)
    e = machine.deviation(np.array([[0.0], [0.0], [0.0], [90.0]]), np.zeros((4, 1)))[:, 0]
    assert e == pytest.approx(
        [0.0, 0.010, 0.0, 0.0], abs=1e-12
    )  # the slides err where they stand, however the part is turned
    turned = flat.copy()
    turned[0] = 0.010  # EXC: the table stands 10 um beside, in the frame that does not turn
    axes["X"], axes["C"] = (
        replace(axes["X"], table=None),
        replace(axes["C"], table=AxisTable("C", nodes, turned, turned)),
    )
    machine = Machine("m", "", "linuxcnc", chain, axes)
    e = machine.deviation(np.array([[0.0], [0.0], [0.0], [90.0]]), np.zeros((4, 1)))[:, 0]
    assert e == pytest.approx([0.010, 0.0, 0.0, 0.0], abs=1e-12)


def test_a_centre_line_beside_its_place_swings_round():
    """X0C = 10 um, turned by 180 degrees: the part swings to the other side, 20 um off; not turned,
    nothing is."""
    chain = parse("w-C-b-X-Y-t")
    axes = {x: Axis(x, (-400, 400), 1e-4, np.zeros(3)) for x in "XYC"}
    axes["C"] = replace(axes["C"], location=np.array([0.010, 0, 0, 0, 0, 0]))
    machine = Machine("m", "", "linuxcnc", chain, axes)
    pose = np.array([[30.0, 30.0], [0.0, 0.0], [0.0, 180.0]])
    e = machine.deviation(pose, np.zeros_like(pose))
    assert e[:, 0] == pytest.approx([0, 0, 0], abs=1e-12)
    # In the part: D N D^-1 moves by shift - R shift = 2 x 10 um along +X of the part, which at 180
    # degrees is the slide's -X.
    assert e[:, 1] == pytest.approx([-0.020, 0, 0], abs=1e-12)


def test_parallel_slides_are_refused():
    chain = parse("w-b-X-C-Y-Z-t")
    axes = {
        x: Axis(
            x,
            (-400, 400),
            1e-4,
            np.zeros(3),
            AxisTable(x, np.array([-400.0, 400.0]), np.full((6, 2), 1e-5), np.full((6, 2), 1e-5)),
        )
        for x in "XYZC"
    }
    machine = Machine("m", "", "linuxcnc", chain, axes)
    with pytest.raises(MachineError, match="directions of their own"):
        machine.deviation(np.array([[0.0], [0.0], [0.0], [90.0]]), np.zeros((4, 1)))
