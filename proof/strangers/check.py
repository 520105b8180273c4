"""Self-check: determinism, formats by the contracts, plausible truths, finite energies."""

from __future__ import annotations

import csv
import io
import itertools
import math
import time
import tomllib

from .base import Case
from .plans import EFFECTS
from .registry import FAMILIES
from .tiers import TIERS, make

NEED = {
    "targets": ["run", "t_s"],
    "trace": ["run", "t_s"],
    "ballbar": ["run", "t_s", "radial_um", "sense"],
    "features": ["feature", "kind", "axis", "nominal_mm", "measured_mm", "part", "reading"],
}
PARAMETERS = {
    "size_um",
    "period_mm",
    "amplitude_um",
    "tau_ms",
    "delta_tau_ms",
    "frequency_hz",
    "urad",
    "arm_mm",
    "um_per_N",
    "diameter_um",
    "jump_um",
    "t_s",
    "delay_ms",
}


def check_recording(body: str, axes: list[str], travel: dict[str, list[float]]) -> float:
    """One recording by its contract; returns its first time (s), -1 for parts."""
    lines = body.splitlines()
    head = tomllib.loads("\n".join(x[2:] for x in lines if x.startswith("# ")))
    assert head["format"] == "gcomp-recording/1"
    rows = list(csv.DictReader(io.StringIO("\n".join(x for x in lines if x[:2] != "# "))))
    need, kind = list(NEED[head["kind"]]), head["kind"]
    if kind == "targets":
        need += [f"{a}_mm" for a in axes] + [f"approach_{a}" for a in axes]
        need += ["reading_urad" if head["quantity"] == "angle" else "reading_um"]
        assert abs(sum(v * v for v in head["sensitive"].values()) - 1) < 1e-6
        assert {r[f"approach_{a}"] for r in rows for a in axes} <= {"1", "-1"}
    if kind == "trace":
        assert head["sees"] in ("scale", "tool")
        need += [f"{a}_{k}_mm" for a in axes for k in ("cmd", "act")]
    if kind == "ballbar":
        assert len(head["centre"]) == 2 and head["radius_mm"] > 0 and head["feed_mm_min"] > 0
        need += [f"{a}_cmd_mm" for a in head["centre"]]
    assert rows and not set(need) - set(rows[0]), set(need) - set(rows[0])
    for r in rows[:: max(1, len(rows) // 50)]:
        for k, v in r.items():
            assert k in ("feature", "kind", "axis") or math.isfinite(float(v)), (k, v)
    for a in axes:
        for k in (f"{a}_mm", f"{a}_cmd_mm"):
            if k in rows[0]:
                x = [float(r[k]) for r in rows]
                assert min(x) >= travel[a][0] - 1e-6 and max(x) <= travel[a][1] + 1e-6, (k, a)
    if kind == "features":
        return -1.0
    t = [float(r["t_s"]) for r in rows]
    assert all(b >= a for a, b in itertools.pairwise(t))
    return t[0]


def check_case(c: Case, tier: str) -> None:
    """A case as a whole."""
    toml = tomllib.loads(c.files["machine/machine.toml"])
    axes = list(toml["axes"])
    travel = {a: toml["axes"][a]["travel"] for a in axes}
    assert toml["format"] == "gcomp-machine/1" and len(c.name) == 9 and c.name[0] == "s"
    for a in axes:
        rows = list(csv.reader(io.StringIO(c.files[f"machine/{a}.csv"])))
        assert rows[0][0] == f"{a}_mm" and len({len(r) for r in rows}) == 1
        x = [float(r[0]) for r in rows[1:]]
        assert x == sorted(x) and x[0] <= travel[a][0] + 1e-6 and x[-1] >= travel[a][1] - 1e-6
    names = sorted(n for n in c.files if not n.startswith("machine/"))
    assert 1 <= len(names) <= 6
    starts = [check_recording(c.files[n], axes, travel) for n in names]
    starts += [check_recording(x, axes, travel) for x in c.follow_up.values()]
    real = [s for s in starts if s >= 0]
    assert real == sorted(real)
    assert bool(c.truth) <= (tier not in ("null", "adversarial"))
    assert bool(c.follow_up) == (tier == "blind")
    count = {"pair": 2, "triple": 3}.get(tier, 1)
    assert len(c.truth) <= count
    for t in c.truth + c.details.get("blind", {}).get("follow_up", []):
        assert t["effect"] in EFFECTS or t["effect"].startswith("alien:")
        assert all(math.isfinite(t[k]) for k in ("peak_um", "energy", "apart"))
        assert t["apart"] <= t["energy"] * 1.001 + 1e-6 and set(t["parameters"]) <= PARAMETERS
    if tier != "blind":
        top = 8.0 if tier == "masked" else 16.0
        assert all(1.0 < t["peak_um"] < top * 1.1 for t in c.truth), c.truth
    if tier == "blind" and c.details["blind"]["spot"] != "one_sense":
        assert not any(t["visible"] for t in c.truth), c.truth


def check(count: int = 5) -> None:
    """All tiers of all families; prints a line for each."""
    for family in FAMILIES:
        for tier in TIERS:
            t0, seen, total = time.time(), 0, 0
            for k in range(count):
                c = make("check", tier, k, family)
                check_case(c, tier)
                seen, total = seen + sum(t["visible"] for t in c.truth), total + len(c.truth)
            spent = (time.time() - t0) / count
            assert make("check", tier, 0, family) == make("check", tier, 0, family)
            print(f"{family:6s} {tier:12s} visible {seen}/{total}  {spent:.2f} s each")
