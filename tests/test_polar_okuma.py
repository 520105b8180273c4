"""Polar interpolation of Okuma lathes: what a Haas does under G112 with G1 to G3 they do under G137
with G101 to G103, whose arcs have L alone."""

from __future__ import annotations

import re

import numpy as np
import pytest

from postproc.errors import GcompError
from tests.test_polar_interpolation import CHAINS, corrected, load, random_truth
from tests.test_tool_point import plain

HEAD = "G0 X60. Z5. C30.\nG17 G94\n"


def haas(lines: list[str]) -> str:
    return "G21 G98 G40\n" + HEAD.replace(" G94", "") + "G112\n" + "\n".join(lines) + "\nG113\n"


def okuma(lines: list[str]) -> str:
    own = [re.sub(r"\bG([123])\b", r"G10\1", x).replace("R", "L") for x in lines]
    return HEAD + "G137 C30.\n" + "\n".join(own) + "\nG136\n"


def between(text: str, on: str, off: str) -> list[str]:
    inside = text.partition(on)[2].partition(off)[0]
    return [x for x in inside.splitlines()[1:] if x.strip()]


@pytest.mark.parametrize("seed", range(4))
def test_lines_are_corrected_as_on_a_haas(seed, tmp_path):
    rng = np.random.default_rng(seed)
    truth = random_truth(rng, CHAINS[0]) if seed else random_truth(rng, CHAINS[1])
    lines = ["G1 X25. Y0. F100."]
    for _ in range(12):
        lines.append(f"X{rng.uniform(8, 30):.3f} Y{rng.uniform(-20, 20):.3f}")
    found = []
    for name, text, marks in (
        ("haas-lathe", haas(lines), ("G112", "G113")),
        ("okuma-lathe", okuma(lines), ("G137", "G136")),
    ):
        folder = tmp_path / name
        folder.mkdir()
        before = "G0 Y0.\n" if "Y" in truth.axes else ""
        output, verifier = corrected(load(truth, folder, name), name, before + text)
        assert verifier.passed
        found.append(between(output, *marks))
    assert [x.replace("G101", "G1") for x in found[1]] == found[0]
    assert len(found[0]) > len(lines)


@pytest.mark.parametrize("seed", range(4))
def test_arcs_keep_their_radius_word_or_become_lines(seed, tmp_path):
    """The manual's G102 and G103 have L, and no I and J."""
    truth = random_truth(np.random.default_rng(seed), CHAINS[0])
    machine = load(truth, tmp_path, "okuma-lathe")
    lines = ["G1 X25. Y0. F100.", "G3 X0. Y25. R25.", "G2 X-10. Y15. R12.", "G1 X-10. Y5."]
    output, verifier = corrected(machine, "okuma-lathe", okuma(lines))
    inside = between(output, "G137", "G136")
    assert verifier.passed
    assert not any("I" in x or "J" in x or "R" in x for x in inside)
    named = [x for x in inside if "G" in x]
    assert {re.match(r"G(\d+)", x)[1] for x in named} <= {"101", "102", "103"}
    assert all(("L" in x) == x.startswith(("G102", "G103")) for x in named)


def test_any_cut_gives_the_same_bytes_and_no_error_changes_none(tmp_path):
    truth = random_truth(np.random.default_rng(5), CHAINS[0])
    machine = load(truth, tmp_path, "okuma-lathe")
    text = okuma(["G1 X25. Y0. F100.", "G3 X0. Y25. R25.", "G1 X-10. Y25."])
    whole = corrected(machine, "okuma-lathe", text)[0]
    assert corrected(machine, "okuma-lathe", text, 7)[0] == whole != text
    perfect = load(plain(CHAINS[0]), tmp_path, "okuma-lathe")
    assert corrected(perfect, "okuma-lathe", text)[0] == text


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ("G137 C30.\nG1 X25. Y0. F100.", "G0 to G3 in polar interpolation"),
        ("G137 C40.\nG101 X25. Y0. F100.", "G137 C40. is not where C stands"),
        ("G101 X25. C0. F100.", "G101"),
        ("G137 C30.\nG101 X25. Y0. F100.\nG136\nX80.", "G101"),
    ],
)
def test_what_is_refused(lines, said, tmp_path):
    machine = load(random_truth(np.random.default_rng(1), CHAINS[0]), tmp_path, "okuma-lathe")
    with pytest.raises(GcompError, match=re.escape(said)):
        corrected(machine, "okuma-lathe", HEAD + lines + "\nG0 X90.\n")
