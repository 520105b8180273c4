"""Which of two that say the same of the readings, where more is known than the readings.

A lag in proportion to the speed is that of a position loop, or the viscous friction over the static
stiffness of the drive. The force tells the friction; both together tell the stiffness that the
drive would have to have. In a cascade without integral action that is the mass times the gains of
its position and its velocity loop (Gross, Hamann, Wiegaertner, Electrical Feed Drives in
Automation, 2001). A current tells the friction over the mass, as it accelerates the mass too.

An angle between two axes is one of either of them: the forms differ by a turn of the part, of which
circles and diagonals say nothing. The axis that leans is the one of the machine's file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from postproc import effects
from postproc.calibrate.square import name_for
from postproc.diagnose import library
from postproc.diagnose.drive import Drive
from postproc.diagnose.search import Search
from postproc.diagnose.sets import Found
from postproc.machine.model import Machine

LAG, FRICTION, INERTIA = "servo_lag", "viscous_friction", "inertia"
ANGLE = "squareness"
# 1/s2, stiffness over mass: gains of 50 and 200 1/s, to a drive as stiff as its screw; with lower
# gains the loop itself lags by more
STIFF = 1e4, 1e7
# where the signal does not show the mass: kg; and 1/s, what a current may be of (a slide of 95 kg:
# Janot, Gautier, Brunot, EMPS, Nonlinear System Identification Benchmarks 2019)
MASS, DAMPING = 100.0, 2.0


def attributed(search: Search, state: Found, drives: Sequence[Drive]) -> Found:
    """The set in which a lag that the drive's force shows to be viscous friction has that name."""
    of_axis = {d.axis: _damping(d) for d in drives}
    members = [search.sets.blocks[k] for k in state.members]
    for k, block in zip(state.members, members, strict=True):
        both = any(b.name == FRICTION and b.axis == block.axis for b in members)
        if block.name != LAG or both:
            continue
        value = search.sets.value(state.fit, k)
        tau_ms = block.module.parameters(value, dict(block.shape))["tau_ms"]
        # Viscous friction c against a stiffness k is a lag tau = c/k; with c/m of the force, (c/m)
        # / tau is k/m, 1/s2.
        if not STIFF[0] < of_axis.get(block.axis, 0.0) / max(tau_ms * 1e-3, 1e-9) < STIFF[1]:
            continue
        module, shape = effects.load(FRICTION), {"power": 1.0} | dict(block.shape)
        make = partial(library.read, search.sets.rows, module, block.axis, shape)
        same = replace(block, module=module, shape=library.named(shape), make=make)
        others = tuple(m for m in state.members if m != k)
        state = search.sets.of((*others, search.sets.let_in(same)), state.fit.on, state)
    return state


def leaning(search: Search, state: Found, machine: Machine) -> Found:
    """The set in which of two axes the one leans that the machine's file names, or the secondary
    one, wherever the readings do not tell which of them does."""
    sets = search.sets
    for k in state.members:
        block, shape = sets.blocks[k], dict(sets.blocks[k].shape)
        if block.name != ANGLE:
            continue
        leans = name_for(block.axis, dict.fromkeys(machine.square_stated), machine.letters)[2]
        usual = shape | {"leans": float(leans == block.axis[0])}
        make = partial(library.read, sets.rows, block.module, block.axis, usual)
        same = replace(block, shape=library.named(usual), make=make)
        others = tuple(m for m in state.members if m != k)
        other = sets.of((*others, sets.let_in(same)), state.fit.on, state)
        if sets.says_the_same(state, other):
            state = other
    return state


def _damping(drive: Drive) -> float:
    """1/s, viscous friction over the mass, in a force or a current; 0 where it shows none."""
    of = {f.term.name: f.value for f in drive.fitted if not f.delayed}
    if FRICTION not in of:
        return 0.0
    rubs = of[FRICTION][f"{drive.unit}_per_m_s"]
    if INERTIA in of:
        return rubs / of[INERTIA][f"{drive.unit}_per_m_s2"]
    return rubs / MASS if drive.unit == "N" else DAMPING
