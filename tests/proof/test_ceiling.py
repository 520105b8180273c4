"""Names by the true covariance: a log that is late, seen at an energy of 176,000, is told from a
lag by it."""

from __future__ import annotations

from proof import ceiling


def test_what_the_true_covariance_tells_is_named():
    found = ceiling.one("dev14", 10, "open")
    assert isinstance(found, ceiling.Answer) and found.truth == "delay:"
    assert found.right and found.names[0][1] > found.names[1][1] + 100


def test_a_name_that_is_worth_less_is_not_right():
    assert not ceiling.Answer(
        "scale:X", 3.0, "linear", [("cosine:X", 10.0), ("scale:X", 9.0)]
    ).right
    assert not ceiling.Answer("scale:X", 3.0, "linear", []).right
