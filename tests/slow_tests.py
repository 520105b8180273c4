"""Which tests are slow: `pytest -m "not slow"` leaves out those that slow.txt names, each with its
seconds.

    pytest --junitxml=FILE && python -m tests.slow_tests FILE
    pytest -m "not slow" --junitxml=REST && python -m tests.slow_tests FILE REST

writes the list again: the functions whose cases together take most of the time, so many that
`SHARE` of it is left. That was one function in seven. What several functions share (fixtures,
caches) is paid for by the first of them, in the run of the rest by another one: those that
then take `LONG` are listed too.
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

LIST = Path(__file__).with_name("slow.txt")
SHARE = 0.09  # of the time of all tests
LONG = 1.5  # s, of a function in a run without the slow ones
WAITING = "tests/streaming/"  # two thirds of its time it waits for receivers and clocks


def listed() -> dict[str, float]:
    """tests/test_x.py::test_y of each, and its seconds."""
    rows = map(str.split, LIST.read_text().splitlines())
    return {name: float(seconds) for name, seconds in rows}


def name_of(nodeid: str) -> str:
    """Of all cases of a function."""
    return nodeid.partition("[")[0]


def file_of(nodeid: str) -> str:
    return nodeid.partition("::")[0]


def in_order(files: Iterable[str]) -> list[str]:
    """Files that take longest come first, so that all processors end together; those that wait are
    spread evenly among those that count, so that none is idle."""
    seconds = dict.fromkeys(files, 1.0)
    for name, took in listed().items():
        if file_of(name) in seconds:
            seconds[file_of(name)] += took
    place: dict[str, float] = {}  # the share of the time of its kind that is over when it begins
    for waits in (True, False):
        row = [name for name in seconds if name.startswith(WAITING) == waits]
        total, before = sum(seconds[name] for name in row), 0.0
        for name in sorted(row, key=seconds.__getitem__, reverse=True):
            place[name] = before / total
            before += seconds[name]
    return sorted(place, key=place.__getitem__)


def taken(report: Path) -> Counter[str]:
    """Seconds of every function of a report in JUnit's XML."""
    took: Counter[str] = Counter()
    for case in ET.parse(report).iter("testcase"):
        file = case.attrib["classname"].replace(".", "/") + ".py"
        took[f"{file}::{name_of(case.attrib['name'])}"] += float(case.attrib["time"])
    return took


def slowest(report: Path, *rest: Path) -> dict[str, float]:
    """The names, in order, of the slowest functions of a report of all tests, and the seconds of
    each. rest: reports of those that were not slow then."""
    took, names = taken(report), []
    left = took.total()
    limit = SHARE * left
    for name, seconds in took.most_common():
        if left <= limit:
            break
        names.append(name)
        left -= seconds
    found = {name: took[name] for name in names}
    for one in rest:
        alone = taken(one).items()
        found |= {name: s for name, s in alone if s >= LONG and name not in found}
    return dict(sorted(found.items()))


if __name__ == "__main__":
    rows = slowest(*map(Path, sys.argv[1:])).items()
    LIST.write_text("".join(f"{name} {seconds:.1f}\n" for name, seconds in rows))
