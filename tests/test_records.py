"""Records behave as frozen dataclasses do."""

from __future__ import annotations

import copy
import pickle
from dataclasses import FrozenInstanceError, asdict, field, fields, replace

import pytest

from postproc.records import columns, record


@record
class Point:
    x: float
    y: float = 2.0
    names: list[str] = field(default_factory=list)


@record
class Weighed(Point):
    weight: float = 1.0


@columns
class Table:
    x: float


def test_values_by_place_by_name_and_by_default():
    assert (Point(1.0).x, Point(1.0).y, Point(x=1.0, y=3.0).y) == (1.0, 2.0, 3.0)
    assert Point(1.0).names == [] and Point(1.0).names is not Point(1.0).names
    assert Weighed(1.0, 2.0, ["a"], 4.0).weight == 4.0


@pytest.mark.parametrize("values, named", [((), {}), ((1, 2, [], 4), {}), ((1,), {"z": 1})])
def test_what_is_no_field_or_missing_is_an_error(values, named):
    with pytest.raises(TypeError, match="Point takes x, y, names"):
        Point(*values, **named)


def test_a_value_given_twice_is_an_error():
    with pytest.raises(TypeError, match="each once; given: 1 by their place, then x"):
        Point(1.0, **{"x": 2.0})


def test_nothing_can_be_changed():
    point = Point(1.0)
    with pytest.raises(FrozenInstanceError):
        point.x = 2.0
    with pytest.raises(FrozenInstanceError):
        del point.x
    assert point.x == 1.0


def test_compared_and_printed_by_the_fields_but_tables():
    assert Point(1.0) == Point(1.0, 2.0) != Point(1.0, 3.0)
    assert Point(1.0) != Weighed(1.0)
    assert repr(Point(1.0)) == "Point(x=1.0, y=2.0, names=[])"
    assert Table(1.0) != Table(1.0) and hash(Table(1.0)) is not None


def test_dataclasses_own_functions_take_them():
    point = Weighed(1.0, names=["a"])
    assert [f.name for f in fields(point)] == ["x", "y", "names", "weight"]
    assert replace(point, weight=3.0) == Weighed(1.0, 2.0, ["a"], 3.0)
    assert asdict(point) == {"x": 1.0, "y": 2.0, "names": ["a"], "weight": 1.0}
    assert copy.deepcopy(point) == pickle.loads(pickle.dumps(point)) == point
