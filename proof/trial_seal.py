"""What seals a trial: the commit that froze the tool, the seeds that follow from it, and the hashes
that were laid down before anything was answered.

    seed of a tier = SHA-256(freeze commit "/" tier), hex
    cases          = SHA-256 of the list cases.sha256: one line "<sha-256>  <path>" a file, in the
                   order of paths
    truth          = SHA-256 of salt, then of the same list of the sealed folder (truth, details,
                   follow-up recordings)

A seed can not be known before the tool is frozen; who has the commit can make the same cases again.
"""

from __future__ import annotations

import hashlib
import json
import subprocess
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
FORMAT = "gcomp-trial/1"
FROZEN = ("postproc", "machines", "proof/generator", "proof/strangers")  # what a freeze holds still
SALT = "salt"


class SealError(Exception):
    """A byte is not what was committed, or the tool is not the one that was frozen."""


@dataclass
class Commitment:
    """What is published before anything is answered. tiers: name to number of cases."""

    freeze: str
    tiers: dict[str, int]
    seeds: dict[str, str]
    cases: int = 0
    cases_sha256: str = ""
    truth_sha256: str = ""
    format: str = FORMAT
    checked: list[str] = field(default_factory=list)

    def text(self) -> str:
        return json.dumps(asdict(self), indent=1, sort_keys=True) + "\n"

    @classmethod
    def read(cls, path: Path) -> Commitment:
        known: dict[str, Any] = json.loads(path.read_text())
        if known.get("format") != FORMAT:
            raise SealError(f"{path} is no commitment of a trial ({FORMAT})")
        return cls(**known)


def seed(freeze: str, tier: str) -> str:
    """The word from which all cases of a tier follow."""
    return hashlib.sha256(f"{freeze}/{tier}".encode()).hexdigest()


def git(*words: str) -> str:
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        raise SealError(f"git {' '.join(words)}: {done.stderr.strip() or 'failed'}")
    return done.stdout


def frozen(wanted: str = "HEAD") -> str:
    """The full id of the freeze commit. Raises SealError if the tool here is another than at that
    commit."""
    commit = git("rev-parse", "--verify", f"{wanted}^{{commit}}").strip()
    moved = git("diff", "--name-only", commit, "--", *FROZEN).split()
    moved += git("ls-files", "--others", "--exclude-standard", "--", *FROZEN).split()
    if moved:
        raise SealError(
            f"the tool is not the one frozen by {commit[:10]}: {len(moved)} files differ,"
            f" {moved[0]} first; commit the changes and freeze that commit, or go back to the"
            " frozen one"
        )
    return commit


def listing(folder: Path, without: tuple[str, ...] = ()) -> str:
    """One line a file, as sha256sum writes and checks it."""
    lines = []
    for path in sorted(folder.rglob("*"), key=lambda p: p.relative_to(folder).as_posix()):
        name = path.relative_to(folder).as_posix()
        if path.is_file() and name not in without:
            lines.append(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {name}\n")
    return "".join(lines)


def of_cases(folder: Path) -> str:
    return hashlib.sha256(listing(folder).encode()).hexdigest()


def of_truth(folder: Path, salt: bytes) -> str:
    return hashlib.sha256(salt + listing(folder, (SALT,)).encode()).hexdigest()


def check(
    commitment: Commitment, cases: Path, sealed: Path | None, listed: Path | None = None
) -> None:
    """Raises SealError where cases or truth are not those that were committed; names the first file
    that differs where the list of the cases' files is at hand."""
    if of_cases(cases) != commitment.cases_sha256:
        raise SealError(
            f"the cases in {cases} are not those that were"
            f" committed{_first_difference(cases, listed)}"
        )
    if sealed is None:
        return
    if not (sealed / SALT).is_file():
        raise SealError(
            f"{sealed} holds no {SALT}: the truth can not be checked against the commitment"
        )
    if (
        of_truth(sealed, bytes.fromhex((sealed / SALT).read_text().strip()))
        != commitment.truth_sha256
    ):
        raise SealError(
            f"the truth in {sealed} is not that which was committed: its salted SHA-256 is another"
        )


def _first_difference(folder: Path, listed: Path | None) -> str:
    if listed is None or not listed.is_file():
        return ""
    was, now = (
        dict(reversed(line.split("  ", 1)) for line in text.splitlines())
        for text in (listed.read_text(), listing(folder))
    )
    bad = sorted(name for name in {*was, *now} if was.get(name) != now.get(name))
    return f": {len(bad)} files differ, {bad[0]} first" if bad else ""
