"""Every control with its table takes the machine's deviation out, to what the export says is left;
with the sign of the file turned the deviation is there twice. Readers do what the control does, and
writing what was read gives the same bytes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import models
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from postproc import control_tables
from postproc.control_tables import ErrorTable, ExportOptions
from postproc.recordings import Source

NANOMETRE = 1e-6  # mm
FINE = 5 * NANOMETRE
INCH = 25.4


@dataclass(frozen=True)
class Case:
    """A control and how it is set up. zero: the approach for which nothing is added at the
    reference, 0 the mean of both, None where the control does not ask for that; own: whether it
    only holds tables along the moving axis."""

    control: str
    options: ExportOptions
    zero: float | None = None
    own: bool = True

    @property
    def id(self) -> str:
        extra = ",".join(f"{k}={v}" for k, v in self.options.extra.items())
        return (
            f"{self.control} {self.options.unit} {extra}"
            f" {'' if self.options.two_way else 'one-way'}"
        )

    def model(self, export, turn=1.0):
        o, files = self.options, export.files
        unit = INCH if o.unit == "inch" else 1.0
        first = next(iter(files.values()))
        home = {x: o.reference.get(x, 0.0) for x in "XYZ"}
        if self.control == "linuxcnc":
            return models.linuxcnc(files, o.extra["type"], unit, turn)
        if self.control == "siemens-enc-comp":
            return models.enc_comp(files, export.notices, unit, turn)
        if self.control == "siemens-cec":
            return models.cec(files, unit, turn if o.extra["cec_sign"] == "-" else -turn)
        if self.control == "fanuc":
            text = next(data for name, data in files.items() if name.endswith(".nc")).decode()
            if o.extra.get("form") == "l52":
                assert "G10 L52" in text
            small = 0.001 if o.unit == "mm" else 0.0001 * INCH
            if o.unit == "inch" and o.extra.get("form") == "l52":
                small = 0.0001 * INCH
            text = _lengths(text, small / (INCH if o.unit == "inch" else 1.0))
            return models.fanuc(text, home, o.step, small, o.extra.get("axes", "XYZ"), turn)
        if self.control == "heidenhain":
            return models.heidenhain(files, unit, turn)
        if self.control == "haas":
            return models.haas(first, home, turn)
        if self.control == "fagor":
            return models.fagor(first, unit, turn)
        return models.mitsubishi(first, o.step, turn)


def _lengths(text: str, small: float) -> str:
    """G10 L52 writes the interval as a length: as a count, for the model."""
    lines = []
    for line in text.splitlines():
        if line.startswith("N3624") and "." in line:
            word, value = line.rsplit("R", 1)
            line = f"{word}R{round(float(value) / small)}"
        lines.append(line)
    return "\n".join(lines)


MM, INCHES = (
    ExportOptions(reference={"X": 0.0, "Z": 40.0}),
    ExportOptions(unit="inch", reference={"X": 0.0, "Z": 40.0}),
)
ONE = replace(MM, two_way=False)
TOP = replace(MM, reference={"X": 600.0, "Z": 700.0})
CEC = {"cec_sign": "-"}  # as the one public generator
CASES = [
    Case("linuxcnc", replace(MM, extra={"type": "0"})),
    Case("linuxcnc", replace(INCHES, extra={"type": "1"})),
    Case("linuxcnc", replace(ONE, extra={"type": "1"})),
    Case("siemens-enc-comp", replace(MM, spacing=10.0), zero=0.0),
    Case("siemens-enc-comp", replace(INCHES, spacing=12.7), zero=0.0),
    Case("siemens-cec", replace(MM, spacing=10.0, extra=CEC), zero=0.0, own=False),
    Case(
        "siemens-cec", replace(INCHES, spacing=12.7, extra={"cec_sign": "+"}), zero=0.0, own=False
    ),
    Case("siemens-cec", replace(ONE, spacing=10.0, extra=CEC), zero=0.0, own=False),
    Case("fanuc", replace(MM, spacing=10.0), zero=1.0),
    Case(
        "fanuc",
        replace(MM, spacing=20.0, extra={"form": "l52", "return": "+", "axes": "XZ"}),
        zero=1.0,
    ),
    Case("fanuc", replace(ONE, spacing=10.0, step=0.0001, extra={"largest": "127"}), zero=0.0),
    Case("fanuc", replace(ONE, unit="inch", spacing=12.7, extra={"form": "l52"}), zero=0.0),
    Case("heidenhain", MM, own=False),
    Case("heidenhain", replace(INCHES, spacing=12.7), own=False),
    Case("heidenhain", replace(MM, extra={"form": "legacy"}), own=False),
    Case("haas", TOP),
    Case("fagor", MM),
    Case("fagor", replace(INCHES, spacing=12.7)),
    Case("mitsubishi", replace(MM, spacing=10.0), zero=0.0),
]


@st.composite
def tables(draw, moving: str = "X", along: str = "X", amplitude: float = 0.06):
    """A table that bends gently: 2 to 20 nodes, up to 60 um, its two directions up to 10 um
    apart."""
    count = draw(st.integers(2, 20))
    gaps = draw(
        st.lists(st.sampled_from([10.0, 20.0, 25.0, 30.0]), min_size=count - 1, max_size=count - 1)
    )
    start = draw(st.sampled_from([-100.0, -40.0, 0.0, 30.0]))
    nodes = start + np.concatenate([[0.0], np.cumsum(gaps)])
    steps = draw(st.lists(st.integers(-60, 60), min_size=count, max_size=count))
    # up to 6 um between neighbours
    forward = np.clip(np.cumsum(steps) * 1e-4, -amplitude, amplitude)
    play = draw(st.lists(st.integers(-50, 50), min_size=count, max_size=count))
    reverse = forward + np.array(play) * 1e-4 if draw(st.booleans()) else forward
    return ErrorTable(moving, along, nodes, forward, reverse)


@st.composite
def sets(draw):
    """EXX, EZZ, and perhaps the straightness EZX."""
    found = [draw(tables("X", "X")), draw(tables("Z", "Z"))]
    return [*found, draw(tables("X", "Z"))] if draw(st.booleans()) else found


def checked(case: Case, group: list[ErrorTable]):
    """Where the control holds a table: table, what is left by the model of the control, and that
    with the sign turned."""
    module = control_tables.load(case.control)
    export = module.write(group, case.options)
    right, wrong = case.model(export), case.model(export, turn=-1.0)
    for table in group:
        if case.own and table.moving != table.along:
            continue
        back = [
            t
            for name, data in export.files.items()
            for t in _read(module, name, data, case.options)
        ]
        got = next(t for t in back if t.name == table.name)
        places = np.union1d(
            np.union1d(table.nodes, got.nodes),
            np.linspace(table.nodes[0] - 50, table.nodes[-1] + 50, 97),
        )
        left, twice = [], []
        for way in (1.0, -1.0):
            deviation = table.at(places, way)
            left.append(deviation + right(table.moving, table.along, places, way))
            twice.append(deviation + wrong(table.moving, table.along, places, way))
            if case.control != "siemens-enc-comp":  # its backlash is beside the file
                np.testing.assert_allclose(
                    -got.at(places, way), right(table.moving, table.along, places, way), atol=FINE
                )
        yield export, table, places, np.stack(left), np.stack(twice)


def _read(module, name, data, options):
    if name.endswith((".CMA", "straightness.csv")):
        return []
    return module.read(Source(name, data), options)


def span(values: np.ndarray) -> float:
    return float(values.max() - values.min())


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
@settings(max_examples=20, deadline=None)
@given(group=sets())
def test_actual_is_commanded_within_what_is_left_and_the_turned_sign_shows_the_deviation_twice(
    case, group
):
    for export, table, places, left, twice in checked(case, group):
        rest = export.remainder[table.name]
        deviation = np.stack([table.at(places, way) for way in (1.0, -1.0)])
        if case.zero is None:
            assert np.abs(left).max() == pytest.approx(rest, abs=FINE)
            assert abs(np.abs(twice).max() - 2 * np.abs(deviation).max()) <= rest + FINE
        else:  # zero at the reference moves all by a constant
            assert span(left) / 2 - FINE <= rest <= span(left) + FINE
        assert abs(span(twice) - 2 * span(deviation)) <= 2 * rest + 2 * FINE


@pytest.mark.parametrize("case", [c for c in CASES if c.zero is not None], ids=lambda case: case.id)
@settings(max_examples=10, deadline=None)
@given(group=sets())
def test_nothing_is_added_at_the_reference(case, group):
    module = control_tables.load(case.control)
    export = module.write(group, case.options)
    model = case.model(export)
    for table in group:
        if case.own and table.moving != table.along:
            continue
        home = np.array([case.options.reference[table.moving]])
        ways = (case.zero,) if case.zero else (1.0, -1.0)
        added = sum(float(model(table.moving, table.along, home, way)[0]) for way in ways) / len(
            ways
        )
        assert abs(added) <= 1e-5 + NANOMETRE  # 5 decimals of a mm, half of it for each direction


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
@settings(max_examples=10, deadline=None)
@given(group=sets())
def test_what_was_read_writes_the_same_bytes(case, group):
    module = control_tables.load(case.control)
    if case.control == "fanuc":  # a magnification may round increments to ones that need none
        case = replace(
            case, options=replace(case.options, extra={**case.options.extra, "largest": "127"})
        )
    files = module.write(group, case.options).files
    back = [t for name, data in files.items() for t in _read(module, name, data, case.options)]
    again = module.write(back, case.options)
    for name in files:
        if name in again.files and name.endswith(".nc"):  # numbers, without the remarks above them
            assert _numbers(files[name]) == _numbers(again.files[name])
        elif name in again.files:
            assert files[name] == again.files[name]
    assert {t.name for t in back} == {t.name for t in group if not case.own or t.moving == t.along}


def _numbers(data: bytes) -> list[str]:
    return [line for line in data.decode().splitlines() if not line.startswith("(")]


def test_a_control_is_a_module_with_all_that_the_command_shows():
    for name in control_tables.names():
        module = control_tables.load(name)
        assert isinstance(module.TITLE, str) and isinstance(module.VERIFIED, bool) and module.SIGN
