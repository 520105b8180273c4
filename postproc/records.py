"""`@record`, `@columns` and `@mutable`: dataclasses without functions of their own.

For each class dataclasses writes up to six functions and has them compiled while it is imported:
0.2 to 2.8 ms a class, a sixth of the time of a short program. Records share theirs. What is in
dataclasses (`field`, `fields`, `replace`, `asdict`) takes them as its own, and looks at their
fields (0.1 ms a class) when it is first asked.
"""

from __future__ import annotations

from dataclasses import MISSING, Field, FrozenInstanceError, dataclass, field
from operator import attrgetter
from typing import Any, TypeVar, cast, dataclass_transform

Class = TypeVar("Class", bound=type)
Value = TypeVar("Value")
SET = object.__setattr__


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def record(cls: Class) -> Class:
    """Class decorator: as `@dataclass(frozen=True)`."""
    return _with(cls, COMPARED)


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field,))
def columns(cls: Class) -> Class:
    """Class decorator: as `@dataclass(frozen=True, eq=False, repr=False)`, for tables of columns,
    which neither compare nor print."""
    return _with(cls, FROZEN)


@dataclass_transform(eq_default=False, field_specifiers=(field,))
def mutable(cls: Class) -> Class:
    """Class decorator: as `@dataclass(eq=False, repr=False)`, for what changes as a run goes on."""
    return _with(cls, {"__init__": _init_and_more} if hasattr(cls, "__post_init__") else {})


def _with(cls: Class, more: dict[str, Any]) -> Class:
    # of the parent class first, as dataclasses orders fields; a dict, since its keys compare as a
    # set
    names = dict.fromkeys((*getattr(cls, "_names", ()), *cls.__annotations__)).keys()
    said = {x: getattr(cls, x, MISSING) for x in cls.__annotations__}
    own = {x: value for x, value in said.items() if isinstance(value, Field)}
    makers = {x: f.default_factory for x, f in own.items() if f.default_factory is not MISSING}
    said |= {x: f.default for x, f in own.items()}
    defaults = {x: value for x, value in said.items() if value is not MISSING}
    shared = {
        "__init__": _init,
        "__dataclass_fields__": _Fields(cls),
        "_names": names,
        "_order": tuple(names),
        "_defaults": getattr(cls, "_defaults", {}) | defaults,
        "_makers": getattr(cls, "_makers", {}) | makers,
        # a tuple of all values; with one name or none, attrgetter gives no tuple
        "_read": attrgetter(*names) if len(names) > 1 else None,
    }
    for name, value in (shared | more).items():
        setattr(cls, name, value)
    return cls


def names(cls: type) -> tuple[str, ...]:
    """The fields of a record's class, in order."""
    return tuple(cls._names)  # type: ignore[attr-defined]


def replace(record: Value, **changes: Any) -> Value:
    """A record with other values, as dataclasses.replace. Raises TypeError for what is no field."""
    values, fields = record.__dict__, type(record)._names  # type: ignore[attr-defined]
    if len(values) > len(fields):  # a cached property is none of them
        values = {x: values[x] for x in fields}
    return type(record)(**(values | changes))


class _Fields:
    """What dataclasses knows of a class, found when it is first asked: most classes never are."""

    def __init__(self, cls: type):
        self._cls = cls

    def __get__(self, instance: object, cls: type) -> dict[str, Field[Any]]:
        # Without a text dataclasses makes one of the signature: 2 ms where it is the first.
        self._cls.__doc__ = self._cls.__doc__ or self._cls.__name__
        # sets __dataclass_fields__ of the class, in place of this object: it is asked once
        dataclass(init=False, repr=False, eq=False)(self._cls)
        return cast("dict[str, Field[Any]]", self._cls.__dict__["__dataclass_fields__"])


def _init(self: Any, *values: Any, **named: Any) -> None:
    if not values and tuple(named) == self._order:  # as most come
        # the keyword dictionary becomes the record's own: no copy, no assignment field by field
        SET(self, "__dict__", named)
        return
    given = len(values) + len(named)
    if values:
        named.update(zip(self._names, values, strict=False))
    # a field given by its place and by its name: update() has overwritten one, so there are fewer
    repeated = len(named) < given
    if len(named) < len(self._names):
        for name, value in self._defaults.items():
            named.setdefault(name, value)
        for name, make in self._makers.items():
            if name not in named:
                named[name] = make()
    if repeated or named.keys() != self._names:
        raise TypeError(
            f"{type(self).__name__} takes {', '.join(self._names)}, each once; given:"
            f" {len(values)} by their place, then {', '.join(named)}"
        )
    SET(self, "__dict__", named)


def _init_and_more(self: Any, *values: Any, **named: Any) -> None:
    _init(self, *values, **named)
    self.__post_init__()


def _frozen(self: Any, name: str, value: object = None) -> None:
    raise FrozenInstanceError(f"cannot change {name!r}: a {type(self).__name__} stays as it is")


def _values(self: Any) -> tuple[Any, ...]:
    read = self._read
    return read(self) if read else tuple(getattr(self, name) for name in self._names)


def _equal(self: Any, other: object) -> bool:
    return _values(self) == _values(other) if type(other) is type(self) else NotImplemented


def _hash(self: Any) -> int:
    return hash(_values(self))


def _repr(self: Any) -> str:
    named = (f"{name}={getattr(self, name)!r}" for name in self._names)
    return f"{type(self).__qualname__}({', '.join(named)})"


FROZEN = {"__setattr__": _frozen, "__delattr__": _frozen}
COMPARED = FROZEN | {"__eq__": _equal, "__hash__": _hash, "__repr__": _repr}
