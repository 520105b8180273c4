"""Outcomes to a table: value, 95 % interval, target, met or not; and the failures, case by case."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from proof.score import Outcome, Spotted

Z = 1.959964
LIBRARY = ("single", "pair", "triple", "masked", "withheld")  # tiers whose truths have names


@dataclass
class Line:
    """One row: a share (hits of count) or a number. least/most: what is wanted; none where nothing
    is."""

    name: str
    value: float
    count: int
    hits: int | None = None
    least: float | None = None
    most: float | None = None
    failures: list[str] = field(default_factory=list)

    @property
    def interval(self) -> tuple[float, float] | None:
        return None if self.hits is None else wilson(self.hits, self.count)

    @property
    def met(self) -> bool | None:
        """None where nothing is asked or nothing was counted."""
        if (self.least is None and self.most is None) or not self.count or math.isnan(self.value):
            return None
        return (self.least is None or self.value >= self.least) and (
            self.most is None or self.value <= self.most
        )

    @property
    def target(self) -> str:
        if self.least is not None and self.most is not None:
            return f"{self.least:g} to {self.most:g}"
        return (
            f">= {self.least:g}"
            if self.least is not None
            else f"<= {self.most:g}"
            if self.most is not None
            else ""
        )

    def cells(self) -> list[str]:
        if not self.count:
            return [self.name, "0", "", "", self.target, "no case"]
        low_high = "" if self.interval is None else "{:.2f} to {:.2f}".format(*self.interval)
        value = f"{self.value:.3f}" if abs(self.value) < 10 else f"{self.value:.1f}"
        met = {True: "yes", False: "**no**", None: ""}[self.met]
        return [self.name, str(self.count), value, low_high, self.target, met]


def wilson(hits: int, count: int) -> tuple[float, float]:
    """95 % interval of a share (Wilson, J. Am. Stat. Assoc. 22, 1927, 209)."""
    if not count:
        return 0.0, 1.0
    p, n = hits / count, count
    middle = (p + Z * Z / (2 * n)) / (1 + Z * Z / n)
    half = Z / (1 + Z * Z / n) * math.sqrt(p * (1 - p) / n + Z * Z / (4 * n * n))
    return max(0.0, middle - half), min(1.0, middle + half)


def share(
    name: str,
    hits: Iterable[tuple[bool, str]],
    least: float | None = None,
    most: float | None = None,
) -> Line:
    """A share of (hit, what to say of it if it failed). A target of `most` makes the hits the
    failures."""
    listed = list(hits)
    number = sum(bool(h) for h, _ in listed)
    bad = [text for h, text in listed if bool(h) == (most is not None)]
    value = number / len(listed) if listed else math.nan
    return Line(name, value, len(listed), number, least, most, bad)


def quantile(values: Iterable[float], q: float) -> float:
    """Linear between the ordered values."""
    ordered = sorted(values)
    if not ordered:
        return math.nan
    at = q * (len(ordered) - 1)
    low = int(at)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (at - low) * (ordered[high] - ordered[low])


def number(
    name: str, values: list[float], q: float, least: float | None = None, most: float | None = None
) -> Line:
    return Line(name, quantile(values, q), len(values), None, least, most)


def _described(o: Outcome, k: int | None = None) -> str:
    said = ", ".join(o.names) or "nothing"
    truth = "" if k is None else f"{o.truths[k]} of {o.peaks[k]:.1f} um: "
    return (
        f"{o.case} ({o.tier}) {truth}said"
        f" {said}{', unknown' if o.unknown else ''}{'; ' + o.failed if o.failed else ''}"
    )


def lines(outcomes: list[Outcome], blind: list[Spotted]) -> list[Line]:
    """All rows of the table but baselines and loop. Targets: issues 6 and 7 of the project."""
    of = {tier: [o for o in outcomes if o.tier == tier] for tier in {o.tier for o in outcomes}}
    none = [*of.get("null", []), *of.get("adversarial", [])]
    single, several = of.get("single", []), [*of.get("pair", []), *of.get("triple", [])]
    named = [o for tier in LIBRARY for o in of.get(tier, [])]
    found = [
        share(
            "nulls with any name",
            [(bool(o.names), _described(o)) for o in of.get("null", [])],
            most=0.01,
        ),
        share(
            "adversarial nulls with any name",
            [(bool(o.names), _described(o)) for o in of.get("adversarial", [])],
            most=0.02,
        ),
        share("nulls called unknown", [(o.unknown, _described(o)) for o in none]),
    ]
    for low, high, least in ((8.0, 16.01, 0.93), (4.0, 8.0, 0.85), (2.0, 4.0, 0.55)):
        found.append(
            share(
                f"one effect, {low:g} to {high:.0f} um: first name right",
                _by_size(single, low, high, "top"),
                least,
            )
        )
    found += [
        share(
            "  the same where no other name explains it as well",
            [
                (o.top[k], _described(o, k))
                for o in single
                for k in range(len(o.truths))
                if o.apart[k]
            ],
        ),
        share(
            "  truth among the names or their equivalents",
            [(o.in_set[k], _described(o, k)) for o in single for k in range(len(o.truths))],
        ),
        share(
            "one effect: right, given that something was named",
            [(any(o.top), _described(o)) for o in single if o.names and o.truths],
            0.97,
        ),
        share(
            "pairs and triples: precision",
            [
                (n not in o.wrong, f"{_described(o)}; hidden {', '.join(o.truths)}")
                for o in several
                for n in o.names
            ],
            0.93,
        ),
        share(
            "pairs and triples: recall",
            [(o.named[k], _described(o, k)) for o in several for k in range(len(o.truths))],
            0.78,
        ),
        share(
            "  of these, pairs that are easily taken for each other",
            [
                (o.named[k], _described(o, k))
                for o in several
                for k in range(len(o.truths))
                if confused(o.truths)
            ],
        ),
    ]
    for low, high, least in ((4.0, 8.01, 0.85), (2.0, 4.0, 0.55)):
        found.append(
            share(
                f"masked tenfold, {low:g} to {high:.0f} um: first name right",
                _by_size(of.get("masked", []), low, high, "top"),
                least,
            )
        )
    withheld = [
        (o.in_set[k], _described(o, k))
        for o in of.get("withheld", [])
        for k in range(len(o.truths))
    ]
    found.append(share("driver withheld: truth named or in the set", withheld, 0.6))
    found += [
        share(
            "blind test: the spot is named", [(s.named, f"{s.case} {s.spot}") for s in blind], 0.9
        ),
        share(
            "blind test: and its program would show it",
            [(s.tested, f"{s.case} {s.spot}: {s.asked[:160]}") for s in blind],
            0.9,
        ),
        share(
            "follow-up given: the effect named",
            [
                (s.followed, f"{s.case} {s.spot}; wrong names {', '.join(s.extra) or 'none'}")
                for s in blind
                if s.hidden
            ],
            0.9,
        ),
    ]
    alien = [o for o in of.get("alien", []) if o.truths]
    found += [
        share("alien physics: called unknown", [(o.unknown, _described(o, 0)) for o in alien], 0.9),
        Line(
            "alien physics: library names a case",
            _mean([len(o.names) for o in alien]),
            len(alien),
            None,
            None,
            0.5,
        ),
        share(
            "one effect, well named: called unknown all the same",
            [(o.unknown, _described(o)) for o in single if any(o.top)],
            most=0.05,
        ),
    ]
    ratios = [o.after / o.floor for o in named if o.after is not None and o.floor]
    found += [
        number("held-out rms over noise floor: median", ratios, 0.5, most=1.10),
        number("held-out rms over noise floor: 90th percentile", ratios, 0.9, most=1.6),
    ]
    errors = [e for o in named for e in o.errors]
    for effect in ("backlash", "cyclic", "servo_lag"):
        found.append(
            number(
                f"relative error of {effect}: median",
                [v for n, v in errors if n == effect],
                0.5,
                most=0.02,
            )
        )
    held = [o.coverage for o in named if o.coverage is not None]
    inside = [(v, f"{o.case} ({o.tier}) {', '.join(o.names)}") for o in named for v in o.inside]
    found.append(
        Line("held-out readings within their 95 % limits", _mean(held), len(held), None, 0.90, 0.98)
    )
    found.append(share("true parameters within their 95 % intervals", inside, 0.90))
    found[-1].most = 0.98
    found += [
        number("seconds a case: median", [o.seconds for o in outcomes], 0.5, most=2.0),
        share(
            "cases without an answer", [(bool(o.failed), _described(o)) for o in outcomes], most=0.0
        ),
    ]
    return found


def _by_size(outcomes: list[Outcome], low: float, high: float, what: str) -> list[tuple[bool, str]]:
    return [
        (getattr(o, what)[k], _described(o, k))
        for o in outcomes
        for k in range(len(o.truths))
        if low <= o.peaks[k] < high
    ]


def confused(truths: list[str]) -> bool:
    """Whether two of the truths are of a pair that the generator holds to be easily taken for each
    other."""
    from proof.generator.cases import CONFUSABLE

    names = {t.partition(":")[0] for t in truths}
    return any(set(pair) <= names for pair in CONFUSABLE)


def _mean(values: list[float]) -> float:
    return sum(values) / len(values) if values else math.nan


HEAD = ("what", "n", "value", "95 % interval", "target", "met")


def table(rows: list[Line], head: tuple[str, ...] = HEAD) -> str:
    """Markdown."""
    cells = [list(head), ["---"] * len(head), *(r.cells() for r in rows)]
    return "\n".join("| " + " | ".join(c) + " |" for c in cells) + "\n"


def failures(rows: list[Line]) -> str:
    """Under each row with a target, the cases that failed it."""
    parts = []
    for r in rows:
        if r.failures and (r.least is not None or r.most is not None):
            parts.append(f"{r.name}\n" + "\n".join(f"- {text}" for text in r.failures) + "\n")
    return "\n".join(parts)
