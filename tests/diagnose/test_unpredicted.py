"""What readings that took no part lie far off by is no clean bill, whatever wander was learned."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from postproc.cli import main
from postproc.diagnose import judge

STUDER = Path(__file__).resolve().parents[2] / "machines" / "studer-s36"


def answered(folder: Path, added_um, of=("2",), runs=3, noise=0.3) -> dict:
    """The answer to runs along Z, of which these have more: of three the middle one is held out."""
    path, answer = folder / "r.csv", folder / "a.json"
    words = ["simulate", "--test", f"positioning:Z,runs={runs}", "--machine", str(STUDER)]
    assert main([*words, "--noise", f"{noise}", "--seed", "3", "-o", str(path), "--quiet"]) == 0
    lines = path.read_text().splitlines(keepends=True)
    head = [line for line in lines if line.startswith("#")]
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    own = [row for row in rows if row["run"] in of]
    for row, more in zip(own, added_um(np.linspace(-1.0, 1.0, len(own))), strict=True):
        row["reading_um"] = f"{float(row['reading_um']) + more:.3f}"
    out = io.StringIO()
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    path.write_text("".join(head) + out.getvalue())
    main(["diagnose", str(path), "--machine", str(STUDER), "--json", str(answer), "--quiet"])
    return json.loads(answer.read_text())


@pytest.mark.parametrize(
    "size_um, verdict", [(0.0, "nothing-left-out"), (4.0, "unknown"), (6.0, "unknown")]
)
def test_a_run_that_nothing_predicts(tmp_path, size_um, verdict):
    """A zero that creeps during one run of three: more than an instrument in order wanders, and
    nothing that the other runs know of."""
    answer = answered(tmp_path, lambda t: size_um * t)
    assert not [e for e in answer["effects"] if e["status"] == "accepted"]
    assert answer["verdict"] == verdict
    assert (answer["unknown"] is None) == (size_um == 0.0)


@pytest.mark.parametrize("places, verdict", [((4,), "nothing-left-out"), ((4, 9, 15), "unknown")])
def test_several_readings_far_off_are_something_that_comes_and_goes(tmp_path, places, verdict):
    """A slide with two states, 7 um apart, of which the second is taken at some targets in two runs
    of four: no noise, however long its tails may be."""

    def states(t):
        off = np.zeros((4, len(t) // 4))
        for k, place in enumerate(places):
            off[[k % 2, 2 + k % 2], place] = -7.0
        return off.ravel()

    answer = answered(tmp_path, states, of=("1", "2", "3", "4"), runs=4)
    assert not [e for e in answer["effects"] if e["status"] == "accepted"]
    assert answer["verdict"] == verdict


@pytest.mark.parametrize("size_um, verdict", [(0.8, "nothing-left-out"), (3.5, "unknown")])
def test_a_zero_that_wanders_by_far_more_than_the_file_states(tmp_path, size_um, verdict):
    """A floor that settles once, behind a load, beside readings uncertain by 0.2 um."""

    def settled(t):
        return size_um * (1.0 - np.exp(-np.maximum(t + 0.3, 0.0) / 0.3))

    answer = answered(tmp_path, settled, of=("1", "2"), runs=2, noise=0.2)
    assert not [e for e in answer["effects"] if e["status"] == "accepted"]
    assert answer["verdict"] == verdict


@pytest.mark.parametrize("count, told", [(0, 0), (judge.FEWEST - 1, 0), (judge.FEWEST, 1)])
def test_a_few_readings_that_took_no_part_say_nothing(monkeypatch, count, told):
    """20 um off where the noise is 1 um: of five readings it may be chance."""
    rows = np.arange(10)
    off, noise = np.full(10, 20.0), np.ones(10)
    d = SimpleNamespace(held=rows < count, after=off, before=off, noise=noise)
    part = SimpleNamespace(whole=SimpleNamespace(rows=rows))
    monkeypatch.setattr(judge, "_least", lambda unit: 2.0)
    sets = SimpleNamespace(evidence=SimpleNamespace(parts=[part]))
    found = judge._unpredicted(cast(Any, d), cast(Any, sets))
    assert found == [(10.0, 20.0, 0)] * told


@pytest.mark.parametrize("share, verdict", [(0.0, "nothing-left-out"), (0.25, "unknown")])
def test_a_slide_with_two_seats(tmp_path, share, verdict):
    """Every fourth reading by chance 7 um off: the zero lies between the two, so that none is far
    from it."""

    def seats(t):
        return 7.0 * (np.random.default_rng(5).random(len(t)) < share)

    answer = answered(tmp_path, seats, of=("1", "2", "3", "4"), runs=4, noise=0.47)
    assert not [e for e in answer["effects"] if e["status"] == "accepted"]
    assert answer["verdict"] == verdict


@pytest.mark.parametrize(
    "fall, sizes, status",
    [(9.1, 1, "accepted"), (8.9, 1, "tentative"), (11.9, 4, "tentative"), (12.1, 4, "accepted")],
)
def test_a_name_that_the_others_leave_no_more_than_noise_is_tentative(fall, sizes, status):
    """Threshold 8; by noise chi squared is 1 for each size."""
    finding = SimpleNamespace(
        delta_chi2=fall, block=SimpleNamespace(width=sizes), status="accepted"
    )
    judge._significant(cast(Any, SimpleNamespace(findings=[finding], least=8.0)))
    assert finding.status == status
