"""The tool on sealed cases: `gcomp diagnose` as a user calls it, on the case's folder alone."""

from __future__ import annotations

import contextlib
import csv
import hashlib
import io
import json
import os
import shutil
import tempfile
import time
import traceback
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

AGREE = 0.01  # of the stated rms: residuals that say something else make a fit unbelievable


def gcomp(*words: str) -> tuple[int, str]:
    """Run the tool in this process; exit status and what it said. A traceback counts as a status of
    its own."""
    from postproc.cli import main

    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            status = main(list(words))
        except SystemExit as stop:
            status = stop.code if isinstance(stop.code, int) else 1
        except Exception:
            traceback.print_exc()
            status = 99
    return status, said.getvalue()


def answer(case: Path, more: Iterable[Path], out: Path) -> dict[str, Any]:
    """Diagnose one case: answer and machine written under out/<case>; returns what the run cost and
    whether it failed.

    The tool runs in a folder of its own that holds nothing but the recordings and the machine, so
    that its answer is the same wherever the trial lies."""
    place = out.resolve() / case.name
    place.mkdir(parents=True, exist_ok=True)
    fits = place / "residuals.csv"
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as alone:
        recordings = [*sorted(case.glob("r*.csv")), *sorted(more)]
        for path in recordings:
            shutil.copy(path, alone)
        shutil.copytree(case / "machine", Path(alone) / "machine")
        os.chdir(alone)
        try:
            begun, wall = time.process_time(), time.perf_counter()
            status, said = gcomp(
                "diagnose",
                *(p.name for p in recordings),
                "--machine",
                "./machine",
                "--json",
                str(place / "answer.json"),
                "--residuals",
                str(fits),
                "--write-machine",
                str(place / "machine"),
                "--quiet",
                "--force",
            )
            done = {"seconds": time.process_time() - begun, "wall": time.perf_counter() - wall}
        finally:
            os.chdir(here)
    done |= {"case": case.name, "status": status}
    if status:
        return done | {"said": said[-2000:]}
    told = believed(json.loads((place / "answer.json").read_text()), fits)
    fits.unlink(missing_ok=True)
    return done | ({"said": told} if told else {})


def believed(doc: dict[str, Any], fits: Path) -> str:
    """ "" where the residuals, reading by reading, say what the answer states of its fit; else what
    differs."""
    stated = (doc.get("fit") or {}).get("rms_after_um")
    if stated is None:
        return ""
    with fits.open(newline="") as file:
        after = [float(row["after_um"]) for row in csv.DictReader(file) if row["held_out"] == "1"]
    rms = float(np.sqrt(np.mean(np.square(after)))) if after else float("nan")
    if abs(rms - stated) <= AGREE * max(stated, 1e-3):
        return ""
    return f"the answer states {stated} um rms held out, its residuals have {rms:.4g}"


def read(out: Path, case: str) -> dict[str, Any] | None:
    """The answer to a case, or None where there is none."""
    path = out / case / "answer.json"
    return json.loads(path.read_text()) if path.is_file() else None


def run(
    cases: Path,
    out: Path,
    jobs: int,
    follow_up: Path | None = None,
    names: Iterable[str] | None = None,
) -> dict[str, Any]:
    """All cases (or those named), with follow-up recordings where such are given. Returns what each
    run cost."""
    if out.exists() and any(out.iterdir()):
        raise FileExistsError(
            f"{out} holds answers already: a frozen tool has one shot at its cases"
        )
    out.mkdir(parents=True, exist_ok=True)
    chosen = (
        sorted(names)
        if names is not None
        else sorted(p.name for p in cases.iterdir() if p.is_dir())
    )
    work = [
        (cases / n, sorted((follow_up / n).glob("f*.csv")) if follow_up else [], out)
        for n in chosen
    ]
    with ProcessPoolExecutor(jobs) as pool:
        log = {done["case"]: done for done in pool.map(_one, work)}
    (out / "run.json").write_text(json.dumps(log, indent=1, sort_keys=True) + "\n")
    return log


def _one(work: tuple[Path, list[Path], Path]) -> dict[str, Any]:
    return answer(*work)


def digest(out: Path) -> str:
    """SHA-256 over all answers, so that they can be laid down before the truth is opened."""
    total = hashlib.sha256()
    for path in sorted(out.glob("*/answer.json")):
        total.update(path.parent.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()
