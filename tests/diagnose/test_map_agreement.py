"""How sure it is what part of the map readings hold, and what stands in for sizes that
can not be."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

from postproc import recordings
from postproc.diagnose import map_agreement
from postproc.diagnose.assembly import of
from postproc.diagnose.search import Search
from postproc.machine.file import read_machine

MACHINES = Path(__file__).parents[2] / "machines"
TRACE = """# format = "gcomp-recording/1"
# kind = "trace"
# machine = "example-mill"
# instrument = "laser in motion"
# sees = "tool"
run,t_s,X_cmd_mm,X_act_mm
""" + "\n".join(f"1,{k * 0.01:.2f},{0.5 * k:.3f},{0.5 * k:.3f}" for k in range(200))


@pytest.mark.parametrize(("stated_um", "surer_than"), [(None, 0.0), (0.2, 0.1), (2.0, 1.0)])
def test_a_share_of_the_map_is_no_surer_than_the_map(tmp_path, stated_um, surer_than):
    """Rows that hold 1 um of a detail, of a map that is stated to 0.2 and 2 um: six smooth terms of
    the half of that each."""
    folder = tmp_path / "m"
    shutil.copytree(MACHINES / "example-mill", folder)
    if stated_um is not None:
        lines = (folder / "X.csv").read_text().splitlines()
        header = next(k for k, line in enumerate(lines) if line.startswith("X_mm"))
        count = lines[header].count(",")
        rows = [
            ",".join([line.split(",")[0], *[str(stated_um)] * count])
            for line in lines[header + 1 :]
        ]
        (folder / "X_uncertainty.csv").write_text("\n".join([lines[header], *rows]) + "\n")
    machine = read_machine(folder)
    rows = of([recordings.read(recordings.Source("r.csv", TRACE.encode()))], machine)
    along = rows.direction[:, 0] > 0
    detail = np.where(along, 1e-3, 0.0)
    unsure = map_agreement._unsure(rows, machine, detail)
    assert (unsure == 0.0) if stated_um is None else (unsure > surer_than)


@pytest.mark.parametrize(("next_best", "chosen"), [(99.5, "plain"), (90.0, "stribeck")])
def test_a_set_that_says_the_same_stands_in_for_one_that_can_not_be(next_best, chosen):
    """Friction with more of it at slow speeds than there is at all explains most; chosen and then
    dropped it left nothing, where the same name without that part explains as much."""
    worth = {"stribeck": 100.0, "plain": next_best, "lag": 80.0}

    class Sets:
        seen: ClassVar = {}
        evidence = SimpleNamespace(learn=lambda chosen, *_: chosen)

        @staticmethod
        def at_own_form(state):
            return state

        @staticmethod
        def worth_of(fit):
            return worth.get(fit, -np.inf)

        @staticmethod
        def fits(fit, k):
            return k != 0

        @staticmethod
        def everywhere(state):
            return True

    states = [
        SimpleNamespace(
            key=name,
            members=(number,),
            score=worth[name],
            least=np.zeros(1),
            fit=SimpleNamespace(chosen=name, on=frozenset()),
        )
        for number, name in enumerate(worth)
    ]
    search = Search(Sets())
    search._as_it_fits = lambda state: worth[state.key]
    assert search._likeliest(states).key == chosen
