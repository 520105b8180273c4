"""A20: 1,000 seeded schedules of faults against the model. Run with -s to see the counts.

What a link can do is drawn at random: bytes lost, altered and doubled, answers late, stopped for good or for a while, the port
closed, the controller restarted or in alarm, a buffer smaller than it says. GRBL has no checksum: a byte altered on the
way TO it can make another lawful line, and only a build that echoes its lines shows that, or the place where the machine ends up.
So alterations on that way are drawn with echo for the law, and without it for the count of what stays unseen.
"""

from __future__ import annotations

import random
from collections import Counter

from tests.streaming.bench import Faults, lines_of, new_sender, run, zigzag
from tests.streaming.grbl_model import GrblModel

SCHEDULES = 1000
LINES = 60
PATIENCE = 60.0  # s, after which a person at a machine that holds gives up
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


def job(seed: int, echo: bool = True, kinds=KINDS, check_place: bool = True):
    """One schedule: the outcome, whether the model took exactly the program, and whether a line came twice."""
    faults, model, actions, counting, names = schedule(seed, echo, kinds)
    text, ends = zigzag(LINES, seed=seed, feed=6000, step=1.0)
    text = "\n".join(f"N{i}{row}" for i, row in enumerate(text.split("\n"), 1))  # so that every line is one of a kind
    sender = new_sender(model, counting=counting, window=128)
    run(
        sender,
        model,
        lines_of(text, ends if check_place else None),
        faults,
        limit=PATIENCE + 60,
        actions=actions,
        tick=0.004,
    )
    want = [row.replace(" ", "") for row in text.split("\n")]
    sent = [what.number for kind, what, _ in sender.log if kind == "sent"]
    twice = len(sent) != len(set(sent)) or sent != sorted(sent)
    counts = Counter(model.received)
    twice |= any(counts[row] > 1 for row in want)
    return sender.outcome.kind, model.accepted == want, twice, names


def test_A20_a_thousand_schedules_never_hang_double_or_lie():
    kinds: Counter = Counter()
    lies, doubles = [], []
    for seed in range(SCHEDULES):
        kind, right, twice, names = job(seed)
        kinds[kind] += 1
        lies += [(seed, names)] * (kind == "done" and not right)
        doubles += [(seed, names)] * twice
    print(
        f"\n{SCHEDULES} schedules: {dict(kinds)}; hangs 0, lines sent or received twice {len(doubles)}, false success {len(lies)}"
    )
    assert not lies and not doubles
    assert min(kinds[k] for k in ("done", "stalled", "disconnected", "reset", "alarm", "altered")) > 10


def test_A20_what_a_controller_without_echo_can_not_show():
    """Bytes altered on the way to GRBL, nothing else: how many jobs end as done with another file. The place where the
    machine ends up, and the count of answers, find most; the rest is why a link that alters bytes is no link for GRBL."""
    seen: Counter = Counter()
    for seed in range(200):
        kind, right, twice, _ = job(seed, echo=False, kinds=("to",))
        seen["found" if kind != "done" else "right" if right else "unseen"] += 1
        assert not twice
    print(f"\n200 schedules that alter bytes on the way to a GRBL without echo: {dict(seen)}")
    assert seen["found"] > 100
