"""A sealed trial on recordings of another world: `proof/strangers`, written from the contracts and
the literature by somebody who has not read the tool.

    python -m proof.strangers_trial            # make, run, score: cases of a seed that follows from
                                               the freeze commit
    python -m proof.strangers_trial --beside FOLDER   # the same cases with another version of the
                                                      tool (a checkout), too
    python -m proof.strangers_trial --kinds distant   # the last family of kinds, known by numbers
    python -m proof.strangers_trial --kinds unseen --tiers null=60,single=60   # so many cases each

Kinds of noise, of physics and of tests that `held` draws were opened in no development run, but a
trial has shown them by name; a third family, `fresh`, bears numbers instead of names; its cases of
commit `3eaefd253c` were looked at one by one after their trial, so it is fresh no more; a fourth,
`sealed`, bears numbers too; its cases of commit `251846cf0d` were looked at after their trial; a
fifth, `unseen`, bears numbers too and was looked at after five trials; `later`, `apart` and
`distant` bear numbers and draw nothing from the open kinds; `later` was looked at after eleven
trials and `apart` after four, in cases of other seeds.
The seed of a tier is SHA-256 of the freeze commit, "strangers" and the tier; the truth's salted
hash is laid down before the tool is run, that of the answers before the truth is opened. Follow-up
recordings and the loop are not part of it (see proof.trial).
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import secrets
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

from proof import score, score_table, trial_run, trial_seal
from proof.score_table import Line, number, share

TIERS = {
    "null": 300,
    "adversarial": 60,
    "single": 120,
    "pair": 30,
    "triple": 15,
    "masked": 30,
    "withheld": 20,
    "alien": 40,
}
SMALL = {"null": 6, "adversarial": 3, "single": 8, "pair": 2, "alien": 3}
KEPT = {
    "held": "kinds held back",
    "fresh": "fresh kinds",
    "sealed": "sealed kinds",
    "unseen": "unseen kinds",
    "later": "later kinds",
    "apart": "kinds apart",
    "distant": "distant kinds",
}


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m proof.strangers_trial",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--small", action="store_true", help="a trial of a minute")
    parser.add_argument(
        "--share", type=float, default=1.0, help="of the cases of every tier, the first ones"
    )
    parser.add_argument(
        "--tiers", type=counts, help="how many cases of which tiers, such as null=60,single=60"
    )
    parser.add_argument(
        "--kinds", choices=KEPT, default="held", help="the family of kinds beside the open ones"
    )
    parser.add_argument("--freeze", default="HEAD", help="the commit that froze the tool")
    parser.add_argument(
        "--beside", type=Path, help="a checkout of another version of the tool, on the same cases"
    )
    parser.add_argument(
        "--keep",
        type=Path,
        help="folder for commitment and score (proof/trials/<commit>-strangers[-<kinds>])",
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args(argv)
    try:
        freeze = trial_seal.frozen(options.freeze)
        whole = options.tiers or (SMALL if options.small else TIERS)
        tiers = {t: max(1, round(options.share * n)) for t, n in whole.items()}
        found = trial(freeze, tiers, options.keep, options.jobs, options.beside, options.kinds)
    except (trial_seal.SealError, FileExistsError) as error:
        print(f"trial: {error}", file=sys.stderr)
        return 2
    print(found)
    return 0


def counts(text: str, tiers: Iterable[str] = TIERS) -> dict[str, int]:
    """`null=60,single=60` as a table of cases; tiers that it does not name have none."""
    found = {}
    for part in text.split(","):
        tier, _, n = part.partition("=")
        if tier not in tiers or not n.isdigit() or int(n) < 1:
            raise argparse.ArgumentTypeError(
                f"{part!r} is not <tier>=<number of cases>; tiers are {', '.join(tiers)}"
            )
        found[tier] = int(n)
    return found


def trial(
    freeze: str,
    tiers: dict[str, int],
    kept: Path | None,
    jobs: int,
    beside: Path | None,
    kinds: str = "held",
) -> str:
    """Make, run, score; returns the table."""
    name = f"{freeze[:10]}-strangers" + ("" if kinds == "held" else f"-{kinds}")
    work = trial_seal.ROOT / "build" / "trials" / name
    kept = kept or trial_seal.ROOT / "proof" / "trials" / name
    kept.mkdir(parents=True, exist_ok=True)
    truth, details = made(freeze, tiers, work / "cases", jobs, kinds)
    sealed = work / "sealed"
    sealed.mkdir()
    (sealed / "truth.json").write_text(json.dumps(truth, indent=1, sort_keys=True))
    salt = secrets.token_bytes(32)
    laid = {
        "freeze": freeze,
        "tiers": tiers,
        "family": kinds,
        "cases": len(truth),
        "cases_sha256": trial_seal.of_cases(work / "cases"),
        "truth_sha256": trial_seal.of_truth(sealed, salt),
    }
    (kept / "commitment.json").write_text(json.dumps(laid, indent=1) + "\n")
    answers = {"now": work / "answers"}
    trial_run.run(work / "cases", work / "answers", jobs)
    if beside:
        answers["before"] = work / "before"
        with_tool(beside, work / "cases", work / "before", jobs)
    laid |= {f"answers_sha256_{who}": trial_run.digest(out) for who, out in answers.items()}
    (kept / "commitment.json").write_text(json.dumps(laid | {"salt": salt.hex()}, indent=1) + "\n")
    outcomes = {who: judged(out, truth, details) for who, out in answers.items()}
    rows = {who: lines(found) for who, found in outcomes.items()}
    (kept / "score.json").write_text(
        score.kept({who: [asdict(o) for o in found] for who, found in outcomes.items()})
    )
    (kept / "FAILURES.md").write_text(score_table.failures(rows["now"]))
    text = page(laid, rows, outcomes["now"], details)
    (kept / "TABLE.md").write_text(text)
    return text


def made(
    freeze: str, tiers: dict[str, int], folder: Path, jobs: int, kinds: str = "held"
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Cases under the folder; truth and details by name."""
    if folder.exists():
        raise FileExistsError(f"{folder} exists: a frozen tool has one shot at its cases")
    seeds = {
        tier: hashlib.sha256(f"{freeze}/strangers/{tier}".encode()).hexdigest() for tier in tiers
    }
    work = [(seeds[tier], tier, k, folder, kinds) for tier in tiers for k in range(tiers[tier])]
    truth, details = {}, {}
    with ProcessPoolExecutor(jobs) as pool:
        for name, hidden, more in pool.map(_made, work, chunksize=2):
            truth[name], details[name] = hidden, more
    return truth, details


def _made(work: tuple[str, str, int, Path, str]) -> tuple[str, list, dict]:
    from proof.strangers import make

    seed, tier, k, folder, kinds = work
    case = make(seed, tier, k, kinds)
    for path, text in case.files.items():
        place = folder / case.name / path
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")
    return (
        case.name,
        json.loads(json.dumps(case.truth, default=str)),
        json.loads(json.dumps(case.details, default=str)),
    )


def with_tool(tool: Path, cases: Path, out: Path, jobs: int) -> None:
    """The same cases, one shot, with the tool of another checkout."""
    script = (
        "import sys; sys.path[:0] = [{tool!r}, {root!r}]\n"
        "from pathlib import Path\nimport postproc\n"
        "assert Path(postproc.__file__).is_relative_to({tool!r}), postproc.__file__\n"
        "sys.path.remove({tool!r})\nfrom proof import trial_run\n"
        "if __name__ == '__main__': trial_run.run(Path({cases!r}), Path({out!r}), {jobs})\n"
    )
    text = script.format(
        tool=str(tool.resolve()),
        root=str(trial_seal.ROOT),
        cases=str(cases),
        out=str(out),
        jobs=jobs,
    )
    subprocess.run([sys.executable, "-c", text], check=True)


def judged(out: Path, truth: dict[str, Any], details: dict[str, Any]) -> list[score.Outcome]:
    cost = json.loads((out / "run.json").read_text())
    found = []
    for case in sorted(truth):
        outcome = score.judge(
            case,
            details[case]["tier"],
            truth[case],
            trial_run.read(out, case),
            cost[case]["seconds"],
        )
        outcome.failed = (outcome.failed and cost[case].get("said", "").strip()[-160:]) or ""
        found.append(outcome)
    return found


def lines(outcomes: list[score.Outcome]) -> list[Line]:
    """Rows of the table, with the targets that were set for this world."""
    of = defaultdict(list)
    for o in outcomes:
        of[o.tier].append(o)
    single, several = of["single"], [*of["pair"], *of["triple"]]

    def told(o: score.Outcome, k: int) -> str:
        return (
            f"{o.case} ({o.tier}) {o.truths[k]} of {o.peaks[k]:.1f} um: said"
            f" {', '.join(o.names) or 'nothing'}{', unknown' if o.unknown else ''}"
        )

    def each(
        cases: list[score.Outcome], what: str, low: float = 0.0, high: float = 1e9
    ) -> list[tuple[bool, str]]:
        return [
            (getattr(o, what)[k], told(o, k))
            for o in cases
            for k in range(len(o.truths))
            if low <= o.peaks[k] < high
        ]

    def plain(o: score.Outcome) -> str:
        return f"{o.case} ({o.tier}) said {', '.join(o.names) or 'nothing'}"

    alien = [o for o in of["alien"] if o.truths]
    # a run that was ended has no times
    timed = [o.seconds for o in outcomes if o.seconds == o.seconds]
    ratios = [
        o.after / o.floor
        for o in (*single, *several, *of["masked"], *of["withheld"])
        if o.after is not None and o.floor
    ]
    return [
        share("nulls with any name", [(bool(o.names), plain(o)) for o in of["null"]], most=0.01),
        share(
            "adversarial nulls with any name",
            [(bool(o.names), plain(o)) for o in of["adversarial"]],
            most=0.03,
        ),
        share(
            "nulls called unknown",
            [(o.unknown, plain(o)) for o in (*of["null"], *of["adversarial"])],
        ),
        share("one effect, 8 to 16 um: first name right", each(single, "top", 8.0), 0.90),
        share("one effect, 4 to 8 um: first name right", each(single, "top", 4.0, 8.0), 0.85),
        share("one effect, 2 to 4 um: first name right", each(single, "top", 0.0, 4.0), 0.62),
        share("  truth among the names or their equivalents", each(single, "in_set")),
        share(
            "one effect: right, given that something was named",
            [(any(o.top), plain(o)) for o in single if o.names and o.truths],
            0.95,
        ),
        share(
            "pairs and triples: precision",
            [(n not in o.wrong, plain(o)) for o in several for n in o.names],
            0.90,
        ),
        share("pairs and triples: recall", each(several, "named"), 0.80),
        share("  truth among the names or their equivalents", each(several, "in_set")),
        share("masked tenfold: first name right", each(of["masked"], "top")),
        share("driver withheld: truth named or in the set", each(of["withheld"], "in_set")),
        share("alien physics: called unknown", [(o.unknown, plain(o)) for o in alien], 0.92),
        Line(
            "alien physics: library names a case",
            sum(len(o.names) for o in alien) / max(len(alien), 1),
            len(alien),
            None,
            None,
            0.3,
        ),
        number("held-out rms over noise floor: median", ratios, 0.5, most=1.10),
        number("held-out rms over noise floor: 90th percentile", ratios, 0.9, most=1.5),
        share(
            "true parameters within their 95 % intervals",
            [(v, o.case) for o in outcomes for v in o.inside],
            0.90,
        ),
        number("seconds a case: median", timed, 0.5, most=2.0),
        number("seconds a case: 95th percentile", timed, 0.95, most=8.0),
        share(
            "cases without an answer",
            [(bool(o.failed), f"{o.case} {o.failed}") for o in outcomes],
            most=0.0,
        ),
    ]


def page(
    laid: dict[str, Any],
    rows: dict[str, list[Line]],
    outcomes: list[score.Outcome],
    details: dict[str, Any],
) -> str:
    counts = ", ".join(f"{n} {tier}" for tier, n in laid["tiers"].items())
    head = (
        f"Trial of commit `{laid['freeze'][:10]}` on cases of another world,"
        f" {KEPT[laid['family']]}: {laid['cases']} cases ({counts}).  \nSHA-256 of the cases"
        f" `{laid['cases_sha256'][:16]}...`, of the salted truth `{laid['truth_sha256'][:16]}...`,"
        f" of the answers `{laid['answers_sha256_now'][:16]}...`.\n\n"
    )
    return head + table(rows, outcomes, details)


def table(
    rows: dict[str, list[Line]], outcomes: list[score.Outcome], details: dict[str, Any]
) -> str:
    """Rows of the tool now, beside those of the tool before if there are any; then the share named
    by effect, and by kind of noise. outcomes: of the tool now."""
    before = {r.name + str(k): r for k, r in enumerate(rows["before"])} if "before" in rows else {}
    names = (
        "what",
        "n",
        "value",
        "95 % interval",
        "target",
        "met",
        *(["the version before"] if before else []),
    )
    cells = []
    for k, r in enumerate(rows["now"]):
        was = before.get(r.name + str(k))
        cells.append([*r.cells(), *([was.cells()[2]] if was else [])])
    text = "\n".join(
        "| " + " | ".join(c) + " |" for c in [list(names), ["---"] * len(names), *cells]
    )
    return (
        f"{text}\n\nNamed of hidden (singles, masked, pairs, triples):"
        f" {_by_effect(outcomes)}.\n\nNamed of nulls, by kind of noise:"
        f" {_by_noise(outcomes, details)}.\n"
    )


def _by_effect(outcomes: list[score.Outcome]) -> str:
    count: dict[str, list[int]] = defaultdict(lambda: [0, 0, 0])
    for o in outcomes:
        if o.tier in ("single", "masked", "pair", "triple"):
            for k, t in enumerate(o.truths):
                seen = count[t.partition(":")[0]]
                seen[0] += o.named[k]
                seen[1] += o.in_set[k]
                seen[2] += 1
    return ", ".join(
        f"{name} {a}{f' ({b} with sets)' * (a != b)} of {n}"
        for name, (a, b, n) in sorted(count.items())
    )


def _by_noise(outcomes: list[score.Outcome], details: dict[str, Any]) -> str:
    count: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    for o in outcomes:
        if o.tier in ("null", "adversarial"):
            for kind in {
                x["kind"] for file in details[o.case]["noise"].values() for x in file["signal"]
            }:
                count[kind][0] += bool(o.names)
                count[kind][1] += 1
    named = ", ".join(f"{kind} {a} of {n}" for kind, (a, n) in sorted(count.items()) if a)
    return named or "none of any"


if __name__ == "__main__":
    sys.exit(main())
