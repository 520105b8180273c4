"""Which laws of a correction hold for the output of a real program: no byte or motion lost, paths
as long, places beside the nominal ones by no more than a correction.

What is measured here is added up from motions by other code than the one that made them.
"""

from __future__ import annotations

import numpy as np

from postproc.filter import Filter
from postproc.motions import FOREIGN, HOLE, Motions
from postproc.nc.interpreter import Interpreter
from postproc.nc.lexer import lex
from postproc.units import TICKS_PER_MM, UM
from tests.corpus.machines import GAP_UM
from tests.corpus.outcome import Outcome
from tests.corpus.programs import XYZ


def first_difference(a: bytes, b: bytes) -> str:
    """The first line in which two texts differ."""
    first, second = a.split(b"\n"), b.split(b"\n")
    for number, (x, y) in enumerate(zip(first, second, strict=False), 1):
        if x != y:
            return f"line {number}: {x[:80]!r} and {y[:80]!r}"
    return f"{len(first)} lines and {len(second)}"


def whole(filter_: Filter, text: bytes) -> Motions:
    """Motions of a whole program in one batch; "%" lines taken out as a control does."""
    lines, kept, begun = text.split(b"\n"), [], False
    for line in lines:
        if line.strip()[:1] == b"%":
            if begun:
                break
            begun = True
            continue
        kept.append(line)
        begun = begun or bool(line.strip())
    interpreter = Interpreter(filter_.dialect, filter_.setup)
    words = lex(b"\n".join(kept), filter_.dialect.grammar)
    motions, state, _ = interpreter.run(words, interpreter.initial())
    if words.fault and not state.ended:
        raise words.fault
    return motions


def lengths(motions: Motions, rows: list[int]) -> np.ndarray:
    """(N,) mm along X Y Z: straight ways, arcs by their sweep, holes down and up; 0 where an end is
    not known."""
    way = (motions.target - motions.start)[rows] / TICKS_PER_MM
    length = np.sqrt((way**2).sum(axis=0))
    arcs = motions.arcs
    if len(arcs):
        radius = (arcs.radius + arcs.radius_end) / 2
        square = (radius * arcs.sweep) ** 2
        for i, row in enumerate(rows):
            beside = (arcs.first != row) & (arcs.second != row)
            square = square + np.where(beside, way[i, arcs.motion], 0.0) ** 2
        length[arcs.motion] = np.sqrt(square)
    holes = motions.holes
    if len(holes):
        across = np.array([[row != axis for axis in holes.axis] for row in rows])
        length[holes.motion] = np.sqrt(((way[:, holes.motion] * across) ** 2).sum(axis=0))
        length[holes.motion] += 2 * np.abs(holes.level - holes.bottom) / TICKS_PER_MM
    known = (motions.start_known[rows] & motions.target_known[rows]).all(axis=0) & (
        motions.code != FOREIGN
    )
    return np.where(known, length, 0.0)


def measure(outcome: Outcome, filter_: Filter, plain: bytes, counts) -> None:
    """Motions and ways of input and output, each read as a whole."""
    machine, tolerance = filter_.machine, filter_.compensator.tolerance
    rows = [machine.letters.index(x) for x in XYZ if x in machine.letters]
    nominal, out = whole(filter_, plain), whole(filter_, outcome.output)
    if len(nominal) != sum(n for n, _, _ in counts) or len(nominal) != outcome.motions_in:
        outcome.faults.append(f"{len(nominal)} motions as a whole, {outcome.motions_in} in batches")
        return
    begin, owner = 0, []
    for n, motion, _ in counts:
        owner.append(motion + begin)
        begin += n
    owner_all = np.concatenate(owner) if owner else np.zeros(0, np.int64)
    take_up = np.concatenate([t for _, _, t in counts]) if counts else np.zeros(0, bool)
    if len(out) != len(owner_all):
        outcome.faults.append(
            f"{len(owner_all)} pieces were planned, {len(out)} motions stand in the output"
        )
        return
    if len(np.unique(owner_all)) != len(nominal):
        outcome.faults.append(
            f"{len(nominal) - len(np.unique(owner_all))} motions have no piece in the output"
        )
    a, b = lengths(nominal, rows), lengths(out, rows)
    outcome.path_in, outcome.path_out = float(a.sum()), float(b.sum())
    # Where the place is lost and found again the way up to there is not known; both sums leave it
    # out.
    slack = (
        1e-3 * outcome.path_in
        + tolerance * len(out)
        + (GAP_UM + 1) * UM * int(take_up.sum())
        + 0.05
    )
    if len(out) > 4 * len(nominal) + outcome.path_in / 2 + 100:
        outcome.faults.append(
            f"{len(nominal)} motions became {len(out)} on {outcome.path_in:.0f} mm"
        )
    if abs(outcome.path_in - outcome.path_out) > slack:
        outcome.faults.append(
            f"{outcome.path_in:.3f} mm in, {outcome.path_out:.3f} mm out, {slack:.3f} allowed"
        )
    if len(owner_all):
        _same_places(outcome, filter_, nominal, out, owner_all)


def _same_places(
    outcome: Outcome, filter_: Filter, nominal: Motions, out: Motions, owner: np.ndarray
) -> None:
    """The end of each motion's last piece: by no more than a correction beside the nominal end,
    rotary axes on it."""
    last = np.flatnonzero(np.append(owner[1:] != owner[:-1], True))
    away = np.abs(out.target[:, last] - nominal.target[:, owner[last]]) / TICKS_PER_MM
    known = out.target_known[:, last] & nominal.target_known[:, owner[last]]
    if (out.target_known[:, last] != nominal.target_known[:, owner[last]]).any():
        outcome.faults.append(
            "a place is known in the input and not in the output, or the other way round"
        )
    if (out.code[last] == HOLE).any() != (nominal.code == HOLE).any():
        outcome.faults.append("holes were lost or came in")
    for row, letter in enumerate(filter_.machine.letters):
        most = filter_.summary.largest + 0.003 if letter in XYZ else 1e-9
        worst = np.where(known[row], away[row], 0.0)
        if worst.max(initial=0.0) > most:
            k = int(worst.argmax())
            outcome.faults.append(
                f"{letter} ends {worst[k]:.4f} mm from the nominal place in motion"
                f" {int(owner[last[k]])}, largest correction {filter_.summary.largest:.4f}"
            )
