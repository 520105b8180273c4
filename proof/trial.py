"""A sealed trial of `gcomp diagnose`, for anyone to repeat.

    python -m proof.trial repeat --small        # make, run, score: a small trial, a few minutes on
                                                two cores
    python -m proof.trial repeat                # the full one
    python -m proof.trial make | run | score    # the same in steps; --freeze COMMIT, --work FOLDER,
                                                --jobs N, --salt HEX

make   draws the cases from seeds that follow from the commit that froze the tool, seals the truth
       and lays the hashes down in proof/trials/<commit>/commitment.json.
run    gives the tool one case folder after the other (recordings and the user's machine, nothing
       else), lays the hash of all answers down, and only then releases the follow-up recordings of
       the blind tests.
score  checks every hash, opens the truth, judges, closes the loop, runs the baselines, and writes
the table; with
       --page it goes between the marks of docs/PROOF.md.
"""

from __future__ import annotations

import argparse
import json
import os
import secrets
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path

from proof import trial_run, trial_seal
from proof.score import kept
from proof.trial_seal import ROOT, SALT, Commitment, SealError

FULL = {
    "null": 200,
    "adversarial": 68,
    "single": 160,
    "pair": 40,
    "triple": 30,
    "masked": 60,
    "withheld": 50,
    "blind": 50,
    "alien": 60,
}
SMALL = {
    "null": 8,
    "adversarial": 4,
    "single": 12,
    "pair": 3,
    "triple": 2,
    "masked": 4,
    "withheld": 4,
    "blind": 4,
    "alien": 4,
}
PAGE = ROOT / "docs" / "PROOF.md"
BEGIN, END = "<!-- trial: begin -->", "<!-- trial: end -->"


class Places:
    """Where a trial's files are. kept: what goes into the project (proof/trials/<commit>); the rest
    is large and can be made again: cases (what the tool sees), sealed (truth, follow-up recordings,
    salt), first and later (answers)."""

    def __init__(self, freeze: str, small: bool, work: Path | None, kept: Path | None = None):
        name = freeze[:10] + ("-small" if small else "")
        self.work = work or ROOT / "build" / "trials" / name
        self.kept = kept or ROOT / "proof" / "trials" / name
        self.cases, self.sealed = self.work / "cases", self.work / "sealed"
        self.first, self.later = self.work / "first", self.work / "later"
        self.commitment, self.listed = self.kept / "commitment.json", self.work / "cases.sha256"


def make(
    freeze: str,
    tiers: dict[str, int],
    places: Places,
    jobs: int,
    salt: str = "",
    say: Callable = print,
) -> Commitment:
    """Draw and seal the cases. A commitment that exists already must come out the same."""
    if places.cases.exists():
        raise SealError(f"{places.cases} exists: remove {places.work} to make this trial again")
    seeds = {tier: trial_seal.seed(freeze, tier) for tier in tiers}
    work = [
        (seeds[tier], tier, k, places.cases, places.sealed)
        for tier in tiers
        for k in range(tiers[tier])
    ]
    truth: dict[str, list] = {}
    details: dict[str, dict] = {}
    with ProcessPoolExecutor(jobs) as pool:
        for done, (name, hidden, more) in enumerate(pool.map(_made, work, chunksize=2), start=1):
            if name in truth:
                raise SealError(f"two cases are called {name}")
            truth[name], details[name] = hidden, more
            if done % 50 == 0:
                say(f"made {done} of {len(work)} cases")
    for name, value in (("truth.json", truth), ("details.json", details)):
        (places.sealed / name).write_text(json.dumps(dict(sorted(value.items())), indent=1) + "\n")
    known = Commitment.read(places.commitment) if places.commitment.exists() else None
    revealed = places.kept / "revealed.json"
    # a trial that was scored before: the same salt gives the same hash
    if not salt and revealed.exists():
        salt = json.loads(revealed.read_text())["salt"]
    salt = salt or secrets.token_hex(32)
    (places.sealed / SALT).write_text(salt + "\n")
    made = Commitment(
        freeze,
        tiers,
        seeds,
        len(work),
        trial_seal.of_cases(places.cases),
        trial_seal.of_truth(places.sealed, bytes.fromhex(salt)),
    )
    places.listed.write_text(trial_seal.listing(places.cases))
    places.kept.mkdir(parents=True, exist_ok=True)
    if known is None:
        places.commitment.write_text(made.text())
    elif (known.cases_sha256, known.tiers) != (made.cases_sha256, made.tiers):
        raise SealError(
            f"{places.commitment} was made of other cases; another version of numpy or scipy may"
            " round otherwise"
        )
    say(f"sealed {len(work)} cases: {places.commitment}")
    return known or made


def _made(work: tuple) -> tuple[str, list, dict]:
    from proof.generator import cases

    seed, tier, number, folder, sealed = work
    case = cases.make(seed, tier, number)
    for place, texts in (
        (folder / case.name, case.files),
        (sealed / "follow_up" / case.name, case.follow_up),
    ):
        for path, text in texts.items():
            (place / path).parent.mkdir(parents=True, exist_ok=True)
            (place / path).write_text(text, encoding="utf-8")
    sealed.mkdir(parents=True, exist_ok=True)
    return case.name, case.truth, case.details


def run(places: Places, jobs: int, say: Callable = print) -> None:
    """The tool's one shot: all cases; the hash of its answers; then the follow-ups."""
    commitment = Commitment.read(places.commitment)
    trial_seal.check(commitment, places.cases, None, places.listed)
    laid_down = places.kept / "answers.json"
    before = json.loads(laid_down.read_text()) if laid_down.exists() else {}
    log = trial_run.run(places.cases, places.first, jobs)
    laid = {"first_sha256": trial_run.digest(places.first)}
    laid_down.write_text(json.dumps(laid, indent=1) + "\n")
    wrong = sum(bool(d["status"]) for d in log.values())
    say(
        f"{len(log)} cases answered, {wrong} of them with an error;"
        f" {_compared(before, laid, 'first_sha256')}"
    )
    released = places.sealed / "follow_up"
    names = sorted(p.name for p in released.iterdir()) if released.is_dir() else []
    trial_run.run(places.cases, places.later, jobs, released, names)
    laid["later_sha256"] = trial_run.digest(places.later)
    laid_down.write_text(json.dumps(laid, indent=1) + "\n")
    say(f"{len(names)} follow-ups answered; {_compared(before, laid, 'later_sha256')}")


def _compared(before: dict, now: dict, name: str) -> str:
    if name not in before:
        return f"SHA-256 {now[name][:16]}"
    same = (
        "the same answers as were laid down before"
        if before[name] == now[name]
        else "OTHER answers than were laid down before"
    )
    return f"SHA-256 {now[name][:16]}, {same}"


def score(places: Places, jobs: int, page: Path | None = None, say: Callable = print) -> dict:
    """Check, judge, write. Returns the score as it is kept."""
    from proof import trial_judge, trial_page

    commitment = Commitment.read(places.commitment)
    trial_seal.check(commitment, places.cases, places.sealed, places.listed)
    laid = json.loads((places.kept / "answers.json").read_text())
    for name, out in (("first_sha256", places.first), ("later_sha256", places.later)):
        if laid.get(name) != trial_run.digest(out):
            raise SealError(
                f"the answers in {out} are not those whose hash was laid down before the truth was"
                " opened"
            )
    found = trial_judge.judged(places, jobs, say)
    found["commitment"] = asdict(commitment) | laid
    revealed = {"salt": (places.sealed / SALT).read_text().strip()}
    text = trial_page.block(found)
    (places.kept / "revealed.json").write_text(json.dumps(revealed, indent=1) + "\n")
    (places.kept / "score.json").write_text(kept(found))
    (places.kept / "TABLE.md").write_text(text)
    (places.kept / "FAILURES.md").write_text(found["failures"])
    say(text)
    if page:
        page.write_text(trial_page.rewritten(page.read_text(), text, BEGIN, END))
        say(f"{page} rewritten")
    return found


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m proof.trial",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("step", choices=("make", "run", "score", "repeat"))
    parser.add_argument("--small", action="store_true", help="a trial of a few minutes")
    parser.add_argument(
        "--freeze",
        default="HEAD",
        help="the commit that froze the tool (HEAD); the tool here must be that one",
    )
    parser.add_argument("--counts", help="other numbers of cases, like null=20,single=30")
    parser.add_argument(
        "--work", type=Path, help="folder for cases and answers (build/trials/<commit>)"
    )
    parser.add_argument(
        "--keep", type=Path, help="folder for commitment and score (proof/trials/<commit>)"
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--salt", default="", help="hex; a random one without it")
    parser.add_argument(
        "--page", action="store_true", help="write the table and the figures of docs/PROOF.md anew"
    )
    options = parser.parse_args(argv)
    try:
        freeze = trial_seal.frozen(options.freeze)
        tiers = SMALL if options.small else FULL
        if options.counts:
            tiers = {
                name: int(n) for name, n in (pair.split("=") for pair in options.counts.split(","))
            }
        places = Places(freeze, options.small, options.work, options.keep)
        if options.step in ("make", "repeat"):
            make(freeze, tiers, places, options.jobs, options.salt)
        if options.step in ("run", "repeat"):
            run(places, options.jobs)
        if options.step in ("score", "repeat"):
            score(places, options.jobs, PAGE if options.page else None)
            if options.page:
                from proof import figures

                figures.draw(places.kept, ROOT / "docs" / "figures")
    except (SealError, FileExistsError, FileNotFoundError) as error:
        print(f"trial: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
