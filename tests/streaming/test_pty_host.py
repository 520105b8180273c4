"""The bench itself: what a model does wrong is said of the model, not of gcomp."""

from __future__ import annotations

import time

import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals as POSIX has them")

from tests.streaming.pty_host import PtyHost  # noqa: E402
from tests.streaming.stream_process import model  # noqa: E402


def test_a_model_that_fails_is_no_silent_controller():
    made = model()

    def fails(now: float) -> None:
        raise IndexError("pop from an empty deque")

    with pytest.raises(AssertionError, match="the model failed: IndexError"), PtyHost(made):
        made.advance = fails
        time.sleep(0.05)


def test_an_error_says_for_how_long_the_model_stood_still():
    made = model()
    with pytest.raises(ZeroDivisionError) as error, PtyHost(made):
        made.read = lambda now: time.sleep(0.2) or b""
        time.sleep(0.5)
        raise ZeroDivisionError
    (note,) = error.value.__notes__
    assert "the model ended" in note and float(note.split()[-4]) >= 0.2


@pytest.mark.parametrize("seconds", [0.5, 2.0])
def test_the_loop_sleeps_until_something_happens(seconds):
    """A planner that is full leaves room when its first block lies in the segments whole, 50 ms
    before it is over; until then the model need not be asked."""
    made = model()
    made.advance(0.1)
    made.read(0.1)
    rows = [f"G1X{i % 2}F{60 / seconds:g}\n".encode() for i in range(1, made.blocks + 3)]
    made.write(b"".join(rows), 0.1)
    made.advance(0.3)
    made.read(0.3)
    assert made._pending is not None and made.state == "Run"
    due = made.due()
    assert due == pytest.approx(made._planned + made._planner[0][0] - 0.05) and due > 0.3
    before = len(made.received), made.planned
    made.advance(due - 1e-6)
    assert (len(made.received), made.planned) == before and not made.read(due - 1e-6)
    made.advance(due + 1e-6)
    made.advance(due + 0.001)
    assert made.read(due + 0.01) == b"ok\r\n" and len(made.received) == before[0] + 1
