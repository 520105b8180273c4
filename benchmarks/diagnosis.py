"""How well `gcomp diagnose` names what was concealed: cases of proof.generator, scored by the truth beside them.

    python -m benchmarks.diagnosis --seed 7 --kind single --count 100 [--jobs 2] [--list]

Every case is a folder as a stranger would hand it over: a machine and recordings. The table says, by size of the effect: named right
(effect and axis), truth within the answer or its equivalent names, missed, wrong names; and for nulls the share with any name.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
import traceback
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

BANDS = ((8, 1e9), (4, 8), (2, 4), (0, 2))
SAME = {"servo_lag": {"servo_mismatch"}}


def judge(folder: Path) -> dict:
    """What the tool answers to one case."""
    from postproc import recordings
    from postproc.diagnose.analysis import diagnose
    from postproc.machine.file import read_machine

    began = time.process_time()
    try:
        files = sorted(folder.glob("r*.csv"))
        options = recordings.ReadingOptions(strict=False)
        read = [recordings.read(recordings.Source(str(f), f.read_bytes()), options=options) for f in files]
        d = diagnose(read, read_machine(folder / "machine"))
    except Exception:
        return {
            "case": folder.name,
            "error": traceback.format_exc(),
            "names": [],
            "sets": [],
            "verdict": "error",
            "seconds": 0.0,
            "scores": [],
            "unknown": False,
        }
    held = d.held if d.held.any() else ~d.held
    return {
        "case": folder.name, "error": "", "verdict": d.verdict, "seconds": time.process_time() - began,
        "names": [f.block.key for f in d.findings if f.status == "accepted"],
        "sets": [[f.block.key, *f.equivalent] for f in d.findings if f.status == "accepted"],
        "scores": [int(min(f.score, 1e9)) for f in d.findings], "unknown": d.unknown is not None, "blind": [f"{n}:{a}" for n, a, _ in d.blind],
        "before": float((d.before[held] ** 2).mean() ** 0.5 * 1e3), "after": float((d.after[held] ** 2).mean() ** 0.5 * 1e3),
        "coverage": float((abs(d.after[held]) <= 1.96 * d.sigma[held]).mean()),
    }  # fmt: skip


def key_of(effect: dict) -> str:
    return f"{effect['effect']}:{effect['axis'] or ''}"


def hit(truth: str, names: list[str]) -> bool:
    name, _, axis = truth.partition(":")
    return any(n == truth or (n.split(":")[0] == name and sorted(n.partition(":")[2]) == sorted(axis)) for n in names)


def table(truth: dict, answers: list[dict], listed: bool) -> None:
    by_band: dict[tuple, Counter] = {b: Counter() for b in BANDS}
    effects: dict[str, Counter] = {}
    false_names = accepted = 0
    for a in answers:
        effects_in = [e for e in truth[a["case"]] if e.get("visible", True)]
        wanted = [key_of(e) for e in truth[a["case"]]]
        accepted += len(a["names"])
        wrong = [n for n in a["names"] if not any(hit(w, [n]) for w in wanted)]
        false_names += len(wrong)
        for e in effects_in:
            band = next(b for b in BANDS if b[0] <= e["peak_um"] < b[1])
            key = key_of(e)
            outcome = (
                "right"
                if hit(key, a["names"])
                else "in set"
                if any(hit(key, s) for s in a["sets"])
                else "missed"
                if not a["names"]
                else "wrong"
            )
            by_band[band][outcome] += 1
            by_band[band]["n"] += 1
            effects.setdefault(e["effect"], Counter())[outcome] += 1
            if listed and outcome != "right":
                print(
                    f"  {a['case']} {key} {e['peak_um']:.1f} um: {outcome}; said {list(zip(a['names'], a['scores'], strict=False))}{' unknown' if a['unknown'] else ''}"
                )
        if listed and not effects_in and (a["names"] or a["unknown"]):
            print(
                f"  {a['case']} null: said {list(zip(a['names'], a['scores'], strict=False))}{' unknown' if a['unknown'] else ''}"
            )
        if a["error"]:
            print(f"  {a['case']} ERROR {a['error'].splitlines()[-1]}")
            if listed:
                print(a["error"])
    for (low, high), c in by_band.items():
        if c["n"]:
            print(
                f"{low:>3} to {min(high, 99):g} um: n {c['n']:>3}  right {c['right'] / c['n']:.2f}  in set {(c['right'] + c['in set']) / c['n']:.2f}  missed {c['missed'] / c['n']:.2f}  wrong {c['wrong'] / c['n']:.2f}"
            )
    n = len(answers)
    print(f"cases {n}, with any name {sum(bool(a['names']) for a in answers) / n:.3f}, unknown {sum(a['unknown'] for a in answers) / n:.3f}, "
          f"accepted names {accepted}, of these false {false_names}, seconds a case {sum(a['seconds'] for a in answers) / n:.1f}")  # fmt: skip
    for name, c in sorted(effects.items()):
        print(f"  {name:<22}" + "  ".join(f"{k} {v}" for k, v in sorted(c.items())))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", default="1")
    parser.add_argument("--kind", default="single")
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--list", action="store_true")
    parser.add_argument(
        "--cases", metavar="FOLDER", help="cases that exist already, with ../truth/truth.json beside them"
    )
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(options.cases) if options.cases else Path(scratch) / "cases"
        if not options.cases:
            import subprocess
            import sys

            subprocess.run(
                [
                    sys.executable,
                    "-m",
                    "proof.generator",
                    "--seed",
                    options.seed,
                    "--kind",
                    options.kind,
                    "--count",
                    str(options.count),
                    "-o",
                    str(folder),
                ],
                check=True,
            )
        truth = json.loads((folder.parent / "truth" / "truth.json").read_text())
        cases = sorted(p for p in folder.iterdir() if p.is_dir())
        with ProcessPoolExecutor(options.jobs) as pool:
            answers = list(pool.map(judge, cases))
        print(f"kind {options.kind}, seed {options.seed}")
        table(truth, answers, options.list)


if __name__ == "__main__":
    main()
