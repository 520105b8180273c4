"""Records behave as frozen dataclasses do."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from dataclasses import FrozenInstanceError, asdict, field, fields
from functools import cached_property

import pytest

from postproc.records import columns, mutable, names, record, replace


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


@mutable
class Count:
    low: int
    high: int = 9
    seen: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.width = self.high - self.low


@record
class Slope(Point):
    @cached_property
    def double(self) -> float:
        return 2 * self.x


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
    assert dataclasses.replace(point, weight=3.0) == Weighed(1.0, 2.0, ["a"], 3.0)
    assert asdict(point) == {"x": 1.0, "y": 2.0, "names": ["a"], "weight": 1.0}
    assert copy.deepcopy(point) == pickle.loads(pickle.dumps(point)) == point


def test_replace_and_names_as_dataclasses_have_them():
    point = Slope(1.0, names=["a"])
    assert names(Slope) == names(Point) == ("x", "y", "names")
    assert point.double == 2.0  # kept beside the fields, and worked out anew
    assert replace(point, x=3.0) == Slope(3.0, 2.0, ["a"]) and replace(point, x=3.0).double == 6.0
    with pytest.raises(TypeError, match="Slope takes x, y, names"):
        replace(point, z=1.0)


def test_mutable_ones_change_and_finish_their_beginning():
    one, other = Count(1), Count(low=2, high=5)
    one.low = 7
    assert (one.low, one.width, other.width, one.seen) == (7, 8, 3, [])
    assert one.seen is not other.seen and Count(1) != Count(1)
    assert dataclasses.replace(other, low=4).width == replace(other, low=4).width == 1


def test_fields_are_looked_at_when_they_are_first_asked_for():
    @record
    class Late:
        x: float

    assert Late(1.0).x == 1.0
    assert not isinstance(vars(Late)["__dataclass_fields__"], dict)
    assert [f.name for f in fields(Late)] == ["x"]
    assert isinstance(vars(Late)["__dataclass_fields__"], dict)
