"""A20: 1,000 seeded schedules of faults against the model. Run with -s to see the counts.

What a link can do is drawn at random: bytes lost, altered and doubled, answers late, stopped for good or for a while, the port
closed, the controller restarted or in alarm, a buffer smaller than it says. GRBL has no checksum: a byte altered on the
way TO it can make another lawful line, and only a build that echoes its lines shows that, or the place where the machine ends up.
So alterations on that way are drawn with echo for the law, and without it for the count of what stays unseen.
"""

from __future__ import annotations

import random
from collections import Counter

import pytest

from tests.streaming.bench import Faults, lines_of, new_sender, run, zigzag
from tests.streaming.grbl_model import GrblModel

SCHEDULES = 1000
QUIET = 240
LINES = 60
PATIENCE = 60.0  # s, after which a person at a machine that holds gives up
SEEN = 0.02  # mm: what a part shows
KINDS = ("nothing", "back", "late", "pause", "silent", "cut", "reset", "alarm", "small buffer", "to")


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
            plan = {r.randrange(span): r.choice(("drop", "flip", "double")) for _ in range(r.choice((1, 1, 2, 5)))}
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


def job(seed: int, echo: bool = True, kinds=KINDS, feed: int = 6000, step: float = 1.0):
    """One schedule: the outcome, whether the model took exactly the program, whether a line came twice, mm by which the model's
    motions missed theirs (inf: other ones), and the sender's log."""
    faults, model, actions, counting, names = schedule(seed, echo, kinds)
    text, ends = zigzag(LINES, seed=seed, feed=feed, step=step)
    text = "\n".join(f"N{i}{row}" for i, row in enumerate(text.split("\n"), 1))  # so that every line is one of a kind
    sender = new_sender(model, counting=counting, window=128, watched=True)
    run(sender, model, lines_of(text, ends), faults, limit=PATIENCE + 600, actions=actions, tick=0.004)
    want = [row.replace(" ", "") for row in text.split("\n")]
    sent = [what.number for kind, what, _ in sender.log if kind == "sent"]
    twice = len(sent) != len(set(sent)) or sent != sorted(sent)
    counts = Counter(model.received)
    twice |= any(counts[row] > 1 for row in want)
    meant, made = distinct(ends)[1:], [p for p in distinct([ends[0], *model.ends])[1:]]
    pairs = zip(made, meant, strict=True) if len(made) == len(meant) else [((float("inf"),), (0.0,))]
    missed = max((abs(a - b) for one, other in pairs for a, b in zip(one, other, strict=True)), default=0.0)
    return sender.outcome, model.accepted == want, twice, missed, names


def beside(outcome) -> bool:
    """Whether it ended because the machine was seen beside its path."""
    return "beside the path" in outcome.message


def test_A20_a_thousand_schedules_never_hang_double_or_lie():
    """With the path watched, which must say nothing where no motion was altered."""
    kinds: Counter = Counter()
    lies, doubles, false = [], [], []
    for seed in range(SCHEDULES):
        outcome, right, twice, missed, names = job(seed)
        kinds[outcome.kind] += 1
        lies += [(seed, names)] * (outcome.kind == "done" and not right)
        doubles += [(seed, names)] * twice
        false += [(seed, names)] * (beside(outcome) and ("to" not in names or missed <= SEEN))
    print(
        f"\n{SCHEDULES} schedules: {dict(kinds)}; hangs 0, lines sent or received twice {len(doubles)}, false success {len(lies)}, "
        f"false alarms of the path {len(false)}"
    )
    assert not lies and not doubles and not false
    assert min(kinds[k] for k in ("done", "stalled", "disconnected", "reset", "alarm", "altered")) > 10


@pytest.mark.parametrize(("feed", "step", "most"), [(6000, 1.0, 25), (1000, 1.0, 15), (1000, 5.0, 10)])
def test_A20_what_a_controller_without_echo_can_not_show(feed, step, most):
    """Bytes altered on the way to GRBL, nothing else: how many jobs end as done with another file. The path, the place where the
    machine ends up, and the count of answers, find most; the rest is why a link that alters bytes is no link for GRBL."""
    seen: Counter = Counter()
    worst = []
    for seed in range(200):
        outcome, right, twice, missed, _ = job(seed, echo=False, kinds=("to",), feed=feed, step=step)
        done = outcome.kind == "done"
        what = ("right" if right else "harmless" if missed <= SEEN else "unseen") if done else "found"
        seen[what if not beside(outcome) else "found on the path"] += 1
        worst += [round(missed, 3)] * (what == "unseen")
        assert not twice
        assert not beside(outcome) or missed > SEEN
    print(
        f"\n200 schedules that alter bytes on the way to a GRBL without echo, {feed} mm/min, steps up to {step} mm: {dict(seen)}; "
        f"unseen mm {sorted(worst)}"
    )
    assert seen["unseen"] <= most and seen["found on the path"] > 10


def test_A20_jobs_without_faults_or_with_altered_reports_never_raise_the_path_s_alarm():
    """Feeds and lengths that differ, bytes altered on the way back only."""
    kinds: Counter = Counter()
    for seed in range(QUIET):
        outcome, right, _, _, _ = job(seed + 5000, echo=False, kinds=(("nothing",), ("back",), ("late",), ("pause",))[seed % 4],
                                      feed=(6000, 1000, 300)[seed % 3], step=(1.0, 5.0)[seed % 2])  # fmt: skip
        kinds[outcome.kind] += 1
        assert not beside(outcome), (seed, outcome)
        assert right or outcome.kind != "done"
    print(f"\n{QUIET} schedules that alter nothing on the way there: {dict(kinds)}; false alarms of the path 0")
