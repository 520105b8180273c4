"""A20: 1,000 seeded schedules of faults against the model. Run with -s to see the counts.

What a link can do is drawn at random: bytes lost, altered and doubled, answers late, stopped for
good or for a while, the port closed, the controller restarted or in alarm, a buffer smaller than it
says. GRBL has no checksum: a byte altered on the way TO it can make another lawful line, and only a
build that echoes its lines shows that, or the place where the machine ends up. So alterations on
that way are drawn with echo for the law, and without it for the count of what stays unseen.
"""

from __future__ import annotations

import random
import re
from collections import Counter
from dataclasses import dataclass

import pytest

from postproc.streaming import journal, zero
from postproc.streaming.live import Live
from postproc.streaming.outcome import Outcome
from tests.campaigns import cases
from tests.streaming.bench import Faults, lines_of, new_sender, run, zigzag
from tests.streaming.grbl_model import GrblModel

SCHEDULES = 1000
QUIET = cases(60, 240)
UNECHOED = cases(80, 200)
LINES = 60
PATIENCE = 60.0  # s, after which a person at a machine that holds gives up
SEEN = 0.02  # mm: what a part shows
KINDS = (
    "nothing",
    "back",
    "late",
    "pause",
    "silent",
    "cut",
    "reset",
    "alarm",
    "small buffer",
    "to",
    "power",
    "stop",
)


def schedule(seed: int, echo: bool = True, kinds=KINDS):
    """Faults, the model they meet, and what they are."""
    r = random.Random(seed)
    names = r.sample(kinds, r.choice((1, 1, 2, 3))) if len(kinds) > 3 else list(kinds)
    faults = Faults(random=random.Random(seed + 1))
    model = GrblModel(echo=echo, baud=r.choice((115200, 57600, 0)), blocks=r.choice((15, 4)))
    actions = []
    for name in names:
        if name in ("back", "to"):
            span = LINES * (35 if name == "back" and echo else 22)
            plan = {
                r.randrange(span): r.choice(("drop", "flip", "double"))
                for _ in range(r.choice((1, 1, 2, 5)))
            }
            setattr(faults, name, plan)
        elif name == "late":
            faults.lag = r.uniform(0.005, 0.5)
        elif name == "pause":
            faults.stall = (r.uniform(0, 2), r.uniform(0.1, 1.8))
        elif name == "silent":
            faults.stall = (r.uniform(0, 2), 1e9)
        elif name == "cut":
            faults.cut = r.uniform(0.02, 3)
        elif name == "reset":
            faults.reset = r.uniform(0.02, 3)
        elif name == "power":
            faults.power = r.uniform(0.02, 3)
        elif name == "stop":
            actions.append((r.uniform(0.02, 2), lambda s, now: s.hold(now)))
            actions.append((actions[-1][0] + 1.0, lambda s, now: s.stop(now)))
        elif name == "alarm":
            actions.append((r.uniform(0.02, 2), lambda s, now: s.receive(b"ALARM:1\r\n", now)))
        elif name == "small buffer":
            model.rx_size = r.choice((16, 40, 100))
    actions.append((PATIENCE, lambda s, now: s.stop(now)))
    return faults, model, sorted(actions, key=lambda a: a[0]), r.random() < 0.7, names


def distinct(places) -> list[tuple[float, ...]]:
    """Without those that are where the one before is."""
    rows = [tuple(p) for p in places]
    return [b for a, b in zip([(), *rows], rows, strict=False) if a != b]


@dataclass
class Job:
    """One schedule: how it ended; whether the model took exactly the program; whether a line came
    twice; mm by which the model's motions missed theirs (inf: other ones); its faults; what is
    wrong with the way back into it, "" nothing, and motions that it makes twice."""

    outcome: Outcome
    right: bool
    twice: bool
    missed: float
    names: list[str]
    back: str = ""
    again: int = 0


def job(
    seed: int,
    echo: bool = True,
    kinds=KINDS,
    feed: int = 6000,
    step: float = 1.0,
    still: bool = False,
) -> Job:
    """still: with lines between the motions that make no block."""
    faults, model, actions, counting, names = schedule(seed, echo, kinds)
    text, ends = zigzag(LINES, seed=seed, feed=feed, step=step, still=still)
    # so that every line is one of a kind
    text = "\n".join(f"N{i}{row}" for i, row in enumerate(text.split("\n"), 1))
    sender = new_sender(model, counting=counting, window=128, watched=True)
    kept = [journal.head("job.nc", "", "mill", "", sender.account.holds, place=(0.0, 0.0, 0.0))]
    run(
        sender,
        model,
        lines_of(text, ends),
        faults,
        limit=PATIENCE + 600,
        actions=actions,
        tick=0.004,
        kept=kept,
    )
    kept.append(journal.end(sender.outcome, 0.0))
    want = [row.replace(" ", "") for row in text.split("\n")]
    sent = [what.number for kind, what, _ in sender.log if kind == "sent"]
    twice = len(sent) != len(set(sent)) or sent != sorted(sent)
    counts = Counter(model.received)
    twice |= any(counts[row] > 1 for row in want)
    meant, made = distinct(ends)[1:], [p for p in distinct([ends[0], *model.ends])[1:]]
    pairs = (
        zip(made, meant, strict=True) if len(made) == len(meant) else [((float("inf"),), (0.0,))]
    )
    missed = max(
        (abs(a - b) for one, other in pairs for a, b in zip(one, other, strict=True)), default=0.0
    )
    result = Job(sender.outcome, model.accepted == want, twice, missed, names)
    if sender.outcome.kind != "done" and model.accepted == want[: len(model.accepted)]:
        result.back, result.again = way_back(b"".join(kept), model, sender, want)
    return result


def way_back(kept: bytes, model: GrblModel, sender, want: list[str]) -> tuple[str, int]:
    """What would be wrong with beginning again by this journal, and how many motions would be made
    twice: after the controller has finished what it holds, as it does when its cable is cut."""
    now = model.now
    while model.state in ("Run", "Hold") and model.now < now + 60:
        model.write(b"~" if model.state == "Hold" else b"", model.now)
        model.advance(model.now + 0.2)
    past = journal.read(kept, "job.nc.journal")
    moves = [i for i, row in enumerate(want[: len(model.accepted)], 1) if re.search("[XYZ]", row)]
    over = moves[model.made - 1] if model.made else 0
    left = next((i for i in moves if i > over), over + 1)
    unmade = [
        row for row in moves if over < row <= past.executed and is_motion(model, moves.index(row))
    ]
    if unmade:
        return f"lines {unmade} are said to be over, and {over} is the last that is", 0
    place = dict(zip("XYZ", model.place, strict=True))
    controller = sender.protocol.controller
    controller.modal = ["G1", f"F{model.rate:g}"]
    doubt = zero.zero_lost(past, Live({}, {}, place, ()), ("X", "Y", "Z"), controller, False, "")
    if any(model.lost) and not doubt:
        return "its zero is lost, and nothing says so", 0
    if doubt:
        return "", 0
    begin = zero.certain(past, Live({}, {}, place, ()), ("X", "Y", "Z"), controller)
    if begin > left:
        return f"it begins with line {begin}, and line {left} is not made", 0
    return "", sum(
        1 for row in moves if begin <= row <= over and is_motion(model, moves.index(row))
    )


def is_motion(model: GrblModel, i: int) -> bool:
    """Whether this motion is longer than a step."""
    before = model.ends[i - 1] if i else [0.0, 0.0, 0.0]
    return model._steps(model.ends[i]) != model._steps(before)


def beside(outcome) -> bool:
    """Whether it ended because the machine was seen beside its path."""
    return "beside the path" in outcome.message


def test_A20_a_thousand_schedules_never_hang_double_or_lie():
    """With the path watched, which must say nothing where no motion was altered."""
    kinds: Counter = Counter()
    lies, doubles, false, harm, again = [], [], [], [], 0
    for seed in range(SCHEDULES):
        one = job(seed, still=seed % 2 == 1)
        outcome, names = one.outcome, one.names
        kinds[outcome.kind] += 1
        lies += [(seed, names)] * (outcome.kind == "done" and not one.right)
        doubles += [(seed, names)] * one.twice
        false += [(seed, names)] * (beside(outcome) and ("to" not in names or one.missed <= SEEN))
        harm += [(seed, names, one.back)] * bool(one.back)
        again = max(again, one.again)
    print(
        f"\n{SCHEDULES} schedules: {dict(kinds)}; hangs 0, lines sent or received twice"
        f" {len(doubles)}, false success {len(lies)}, false alarms of the path {len(false)};"
        f" restarts that leave something out or trust a lost zero {len(harm)}, motions made twice"
        f" at most {again}"
    )
    assert not lies and not doubles and not false
    assert not harm, harm[:5]
    assert (
        min(kinds[k] for k in ("done", "stalled", "disconnected", "reset", "alarm", "altered")) > 10
    )


@pytest.mark.parametrize(
    ("feed", "step", "most"), [(6000, 1.0, 25), (1000, 1.0, 15), (1000, 5.0, 10)]
)
def test_A20_what_a_controller_without_echo_can_not_show(feed, step, most):
    """Bytes altered on the way to GRBL, nothing else: how many jobs end as done with another file.
    The path, the place where the machine ends up, and the count of answers, find most; the rest is
    why a link that alters bytes is no link for GRBL."""
    seen: Counter = Counter()
    worst = []
    for seed in range(UNECHOED):
        one = job(seed, echo=False, kinds=("to",), feed=feed, step=step)
        outcome, right, twice, missed = one.outcome, one.right, one.twice, one.missed
        done = outcome.kind == "done"
        what = (
            ("right" if right else "harmless" if missed <= SEEN else "unseen") if done else "found"
        )
        seen[what if not beside(outcome) else "found on the path"] += 1
        worst += [round(missed, 3)] * (what == "unseen")
        assert not twice
        assert not beside(outcome) or missed > SEEN
    print(
        f"\n{UNECHOED} schedules that alter bytes on the way to a GRBL without echo, {feed} mm/min,"
        f" steps up to {step} mm: {dict(seen)}; unseen mm {sorted(worst)}"
    )
    share = UNECHOED / 200
    assert seen["unseen"] <= most * share and seen["found on the path"] > 10 * share


def test_A20_jobs_without_faults_or_with_altered_reports_never_raise_the_path_s_alarm():
    """Feeds and lengths that differ, bytes altered on the way back only."""
    kinds: Counter = Counter()
    for seed in range(QUIET):
        one = job(
            seed + 5000,
            echo=False,
            kinds=(("nothing",), ("back",), ("late",), ("pause",))[seed % 4],
            feed=(6000, 1000, 300)[seed % 3],
            step=(1.0, 5.0)[seed % 2],
            still=seed % 3 == 0,
        )
        outcome, right = one.outcome, one.right
        kinds[outcome.kind] += 1
        assert not beside(outcome), (seed, outcome)
        assert right or outcome.kind != "done"
    print(
        f"\n{QUIET} schedules that alter nothing on the way there: {dict(kinds)}; false alarms of"
        " the path 0"
    )
