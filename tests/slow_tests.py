"""Which tests are slow: `pytest -m "not slow"` leaves out those that slow.txt names.

    pytest --junitxml=FILE && python -m tests.slow_tests FILE

writes the list again: the functions whose cases together take most of the time, so many that
`SHARE` of it is left. That was one function in six.
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from collections import Counter
from pathlib import Path

LIST = Path(__file__).with_name("slow.txt")
SHARE = 0.06  # of the time of all tests


def listed() -> frozenset[str]:
    """tests/test_x.py::test_y of each."""
    return frozenset(LIST.read_text().split())


def name_of(nodeid: str) -> str:
    """Of all cases of a function."""
    return nodeid.partition("[")[0]


def slowest(report: Path) -> list[str]:
    """The names, in order, of the slowest functions of a report of all tests, in JUnit's XML."""
    took: Counter[str] = Counter()
    for case in ET.parse(report).iter("testcase"):
        file = case.attrib["classname"].replace(".", "/") + ".py"
        took[f"{file}::{name_of(case.attrib['name'])}"] += float(case.attrib["time"])
    left, names = sum(took.values()), []
    limit = SHARE * left
    for name, seconds in took.most_common():
        if left <= limit:
            break
        names.append(name)
        left -= seconds
    return sorted(names)


if __name__ == "__main__":
    LIST.write_text("\n".join(slowest(Path(sys.argv[1]))) + "\n")
