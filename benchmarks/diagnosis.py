"""How well `gcomp diagnose` names what was concealed: cases of proof.generator, judged as a sealed
trial judges (proof.score).

    python -m benchmarks.diagnosis --seed 7 --kind single --count 100 [--jobs 2] [--list]

For tuning: any seed, as often as wanted. What counts is `python -m proof.trial`. The table says, by
size of the effect: named right (effect and axis, among the accepted names), truth within the answer
or its equivalent names, missed, wrong names.
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

from proof.generator import make
from proof.generator.__main__ import write
from proof.score import Outcome
from proof.score import judge as judged
from proof.score_table import lines, table

BANDS = ((8, 1e9), (4, 8), (2, 4), (0, 2))


def answer(folder: Path) -> tuple[str, dict | None, list[tuple[str, int]], float, str]:
    """Name of the case, what the tool answers, names with their scores, seconds, and the traceback
    if it failed."""
    from postproc import recordings
    from postproc.diagnose import report
    from postproc.diagnose.analysis import diagnose
    from postproc.machine.file import read_machine

    began = time.process_time()
    try:
        files = sorted(folder.glob("r*.csv"))
        options = recordings.ReadingOptions(strict=False)
        sources = [recordings.Source(str(f), f.read_bytes()) for f in files]
        read = [recordings.read(source, options=options) for source in sources]
        d = diagnose(read, read_machine(folder / "machine"))
        scores = [
            (f.block.key, int(min(f.score, 1e9))) for f in d.findings if f.status == "accepted"
        ]
        said = report.as_json(d, [s.sha256 for s in sources])
        return folder.name, said, scores, time.process_time() - began, ""
    except Exception:
        return folder.name, None, [], time.process_time() - began, traceback.format_exc()


def show(outcomes: list[Outcome], scores: dict[str, list], listed: bool) -> None:
    """The short table, by size and by effect."""
    by_band: dict[tuple, Counter] = {b: Counter() for b in BANDS}
    effects: dict[str, Counter] = {}
    for o in outcomes:
        said = f"said {scores[o.case]}{' unknown' if o.unknown else ''}"
        for key, size, named, in_set in zip(o.truths, o.peaks, o.named, o.in_set, strict=True):
            band = next(b for b in BANDS if b[0] <= size < b[1])
            outcome = (
                "right" if named else "in set" if in_set else "missed" if not o.names else "wrong"
            )
            by_band[band].update((outcome, "n"))
            effects.setdefault(key.partition(":")[0], Counter())[outcome] += 1
            if listed and outcome != "right":
                print(f"  {o.case} {key} {size:.1f} um: {outcome}; {said}")
        if listed and not o.truths and (o.names or o.unknown):
            print(f"  {o.case} null: {said}")
        if o.failed:
            print(f"  {o.case} ERROR {o.failed.splitlines()[-1]}")
            if listed:
                print(o.failed)
    for (low, high), c in by_band.items():
        if c["n"]:
            parts = {
                "right": c["right"],
                "in set": c["right"] + c["in set"],
                "missed": c["missed"],
                "wrong": c["wrong"],
            }
            told = "  ".join(f"{name} {v / c['n']:.2f}" for name, v in parts.items())
            print(f"{low:>3} to {min(high, 99):g} um: n {c['n']:>3}  {told}")
    n = len(outcomes)
    print(
        f"cases {n}, with any name {sum(bool(o.names) for o in outcomes) / n:.3f}, unknown"
        f" {sum(o.unknown for o in outcomes) / n:.3f}, accepted names"
        f" {sum(len(o.names) for o in outcomes)}, of these false"
        f" {sum(len(o.wrong) for o in outcomes)}, seconds a case"
        f" {sum(o.seconds for o in outcomes) / n:.1f}"
    )
    for name, c in sorted(effects.items()):
        print(f"  {name:<22}" + "  ".join(f"{k} {v}" for k, v in sorted(c.items())))


def _made(work: tuple) -> None:
    seed, kind, number, folder = work
    case = make(seed, kind, number)
    write(case, folder, folder.parent / f"truth-{number}")


def cases_of(options: argparse.Namespace, folder: Path) -> dict[str, list]:
    """Cases written into `folder`; what is hidden in each."""
    work = [(options.seed, options.kind, k, folder) for k in range(options.count)]
    with ProcessPoolExecutor(options.jobs) as pool:
        list(pool.map(_made, work))
    truth: dict[str, list] = {}
    for path in sorted(folder.parent.glob("truth-*/truth.json")):
        truth |= json.loads(path.read_text())
    return truth


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", default="1")
    parser.add_argument("--kind", default="single")
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--table", action="store_true", help="the table of a trial as well")
    parser.add_argument(
        "--cases",
        metavar="FOLDER",
        help="cases that exist already, with ../truth/truth.json beside them",
    )
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        if options.cases:
            folder = Path(options.cases)
            truth = json.loads((folder.parent / "truth" / "truth.json").read_text())
        else:
            folder = Path(scratch) / "cases"
            truth = cases_of(options, folder)
        cases = sorted(p for p in folder.iterdir() if p.is_dir())
        with ProcessPoolExecutor(options.jobs) as pool:
            answers = list(pool.map(answer, cases))
    outcomes, scores = [], {}
    for name, said, marks, seconds, failed in answers:
        outcomes.append(judged(name, options.kind, truth[name], said, seconds))
        outcomes[-1].failed = failed
        scores[name] = marks
    print(f"kind {options.kind}, seed {options.seed}")
    show(outcomes, scores, options.list)
    if options.table:
        print(table([r for r in lines(outcomes, []) if r.count]))


if __name__ == "__main__":
    main()
