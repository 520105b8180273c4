"""What is over, of what was answered: held against the model of GRBL with planner, segments and
lines without a block."""

from __future__ import annotations

import random

import pytest

from postproc.streaming.account import MOST, Account
from postproc.streaming.events import Status
from postproc.streaming.lines import WireLine
from postproc.streaming.protocols import Controller
from tests.streaming.bench import lines_of, new_sender, run
from tests.streaming.grbl_model import GrblModel

FINE = {"100": "100", "101": "100", "102": "100"}


def account(**how) -> Account:
    made = Account(
        Controller(planner=3, segments=1, settings=FINE) if not how else Controller(**how)
    )
    made.reported(Status("idle", place=(0.0, 0.0)))
    return made


def take(made: Account, *ends: tuple[float, float], text: bytes = b"G1 X1", first: int = 1) -> None:
    for i, end in enumerate(ends, first):
        made.sent(WireLine(i, i, 0, text, end, seconds=1.0))
        made.answered(i)


def test_of_the_answered_all_are_over_but_what_it_holds():
    """3 blocks, with the one that is just being taken, and 1 segment: 7 to 10 may be held, and 6 is
    over when 10 is answered."""
    made = account()
    take(made, *((float(i), 0.0) for i in range(1, 11)))
    assert (made.answered_to, made.executed, made.source, made.seconds) == (10, 6, 6, 6.0)


def test_lines_without_a_motion_and_motions_below_a_step_push_nothing_out():
    made = account()
    take(made, (5.0, 0.0))
    take(made, *((5.0 + 0.0001 * i, 0.0) for i in range(1, 21)), first=2)
    take(made, *[(5.002, 0.0)] * 20, text=b"M8", first=22)
    assert made.executed == 0 and made.lines()[0].number == 1
    take(made, *((float(i), 0.0) for i in range(6, 10)), first=42)
    assert made.executed == 41  # with the last motion that is over goes what stands behind it


def test_a_line_that_waits_for_rest_says_that_all_is_over():
    made = account()
    take(made, (5.0, 0.0), (6.0, 0.0))
    made.sent(WireLine(3, 3, 0, b"G4 P1", (6.0, 0.0)))
    made.answered(3, emptied=True)
    assert made.executed == 3 and not made.parts


def test_rest_seen_twice_says_it_of_what_was_answered_before_the_first():
    made = account()
    take(made, (5.0, 0.0))
    made.reported(Status("run", place=(1.0, 0.0)))
    made.reported(Status("idle", place=(0.0, 0.0)))
    take(made, (6.0, 0.0), first=2)
    assert made.executed == 0
    made.reported(Status("idle", place=(0.0, 0.0)))
    assert made.executed == 1
    made.reported(Status("idle", place=(6.0, 0.0)))
    assert made.executed == 2


def test_a_refused_line_and_the_one_behind_it_are_no_sure_motions():
    made = account()
    for i in range(1, 9):
        made.sent(WireLine(i, i, 0, b"G1 X1", (float(i), 0.0)))
    made.refused(1)
    for i in range(2, 9):
        made.answered(i)
    assert made.executed == 4  # behind 4 stand 5 to 8


def test_many_motions_without_length_take_no_memory():
    made = account()
    take(made, (5.0, 0.0), *((5.0 + (i % 2) * 0.001, 0.0) for i in range(3 * MOST)))
    assert len(made.parts) <= MOST + 1 and made.executed == 0
    take(made, *((float(i), 0.0) for i in range(6, 20)), first=3 * MOST + 2)
    assert made.executed >= 3 * MOST + 1 and len(made.parts) <= 4


@pytest.mark.parametrize("seed", range(12))
def test_nothing_is_said_to_be_over_that_the_model_has_not_made(seed):
    """Random feeds and lengths, from 1 ms a motion and below a step to half a second; M, F and G
    words, dwells and holds in between."""
    r = random.Random(seed)
    model = GrblModel(baud=r.choice((115200, 0)), blocks=r.choice((15, 4)))
    rows, ends, at = ["G21G90G94"], [(0.0, 0.0, 0.0)], [0.0, 0.0]
    for i in range(150):
        kind = r.random()
        if kind < 0.25:
            rows.append(r.choice(("F900", "M8", "G94", "G4P0.01")))
        else:
            at[r.randrange(2)] += r.choice((0.0003, 0.1, 0.5, 3.0)) * r.choice((1, -1))
            at = [round(v, 4) for v in at]
            rows.append(f"G1X{at[0]}Y{at[1]}F{r.choice((600, 3000, 6000))}")
        ends.append((*at, 0.0))
    sender = new_sender(model)
    worst, seen = [], 0

    def look(sender, now) -> None:
        nonlocal seen
        answered, over = len(model.accepted), sender.account.executed
        moves = [i for i, row in enumerate(rows, 1) if row.startswith("G1") and i <= answered]
        real = [
            i
            for a, i in zip([0, *moves], moves, strict=False)
            if model._steps(ends[i - 1]) != model._steps(ends[i - 2])
        ]
        held = len(model._planner)  # blocks that are not made, the newest
        unmade = real[len(real) - held :][:1] if held else []
        seen += over > 0
        worst.extend((over, i) for i in unmade if over >= i)

    run(
        sender,
        model,
        lines_of("\n".join(rows), ends),
        actions=[(t / 50, look) for t in range(1500)],
        limit=3000,
    )
    assert sender.outcome.kind == "done" and not worst and seen > 5, (sender.outcome, worst[:3])


def test_where_the_controller_does_not_say_its_steps_motions_of_a_twentieth_count():
    """1 / 20 mm is coarser than any machine's step; what is shorter may make no block."""
    long, short = account(planner=3, segments=1), account(planner=3, segments=1)
    take(long, *((0.06 * i, 0.0) for i in range(1, 11)))
    take(short, *((0.04 * i, 0.0) for i in range(1, 11)))
    assert (long.executed, short.executed) == (6, 0)
