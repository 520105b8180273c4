"""One run there and back along a diagonal, nothing repeated: what the two ways differ by is no
scatter of the instrument."""

from __future__ import annotations

import json

import numpy as np
import pytest

from postproc.cli import main

MACHINE = """format = "gcomp-machine/1"
name = "m"
control = "linuxcnc"
chain = "w-b-X-Z-t"
[axes.X]
least_increment = 0.0001
travel = [0.0, 200.0]
[axes.Z]
least_increment = 0.0001
travel = [0.0, 450.0]
"""
ALONG = np.array([-0.3, 0.9539392])
HEAD = (
    '# format = "gcomp-recording/1"\n# kind = "targets"\n# machine = "m"\n# instrument ='
    ' "laser interferometer"\n# quantity = "displacement"\n# sensitive = {{ X = {}, Z = {} }}\n'
    "run,t_s,X_mm,Z_mm,approach_X,approach_Z,reading_um\n"
)


@pytest.mark.parametrize("lost_um", [24.0, 0.0])
def test_lost_motion_of_one_run_there_and_back(tmp_path, lost_um):
    """24 um between the ways, 0.2 um of noise and a slow drift of 2 um: lost motion of X or Z,
    which reverse together, so the set of equals holds both. Without it nothing is named."""
    rng = np.random.default_rng(11)
    x, z = np.linspace(121, 9, 9), np.linspace(40, 400, 9)
    rows = []
    for k in range(18):
        at, side = (k, 1) if k < 9 else (17 - k, -1)
        reading = -side * lost_um / 2 + 2.0 * np.sin(k / 5) + rng.normal(0, 0.2)
        rows.append(f"1,{35 + 3.2 * k:.2f},{x[at]:.4f},{z[at]:.4f},{-side},{side},{reading:.3f}")
    (tmp_path / "r.csv").write_text(HEAD.format(*ALONG) + "\n".join(rows) + "\n")
    (tmp_path / "machine").mkdir()
    (tmp_path / "machine" / "machine.toml").write_text(MACHINE)
    answer = tmp_path / "a.json"
    words = ["diagnose", str(tmp_path / "r.csv"), "--machine", str(tmp_path / "machine")]
    main([*words, "--json", str(answer), "--quiet"])
    found = json.loads(answer.read_text())["effects"]
    if not lost_um:
        assert not found
        return
    (one,) = found
    assert one["status"] == "accepted" and one["effect"] == "backlash"
    assert one["parameters"]["size_um"]["value"] == pytest.approx(
        lost_um / abs(ALONG["XZ".index(one["axis"])]), rel=0.1
    )
