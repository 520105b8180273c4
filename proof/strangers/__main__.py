"""Command line: writes cases, or checks itself."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from .registry import FAMILIES
from .tiers import TIERS, make


def main() -> None:
    """python -m proof.strangers --seed S --tier T --count N -o FOLDER [--family apart]."""
    p = argparse.ArgumentParser(prog="proof.strangers")
    p.add_argument("--seed", default="0")
    p.add_argument("--tier", choices=[*TIERS, "all"], default="all")
    p.add_argument("--count", type=int, default=1)
    p.add_argument("--first", type=int, default=0)
    p.add_argument("--family", choices=FAMILIES, default="open")
    p.add_argument("-o", "--out", default="strangers-out/cases")
    p.add_argument("--check", action="store_true")
    a = p.parse_args()
    if a.check:
        from .check import check

        check(a.count)
        return
    out = Path(a.out)
    truth_at = out.parent / "truth"
    truth_at.mkdir(parents=True, exist_ok=True)
    books: dict[str, dict] = {}
    for book in ("truth", "details"):
        f = truth_at / f"{book}.json"
        books[book] = json.loads(f.read_text()) if f.exists() else {}
    for tier in TIERS if a.tier == "all" else [a.tier]:
        for k in range(a.first, a.first + a.count):
            c = make(a.seed, tier, k, a.family)
            more = {"follow_up/" + k: v for k, v in c.follow_up.items()}
            for name, body in {**c.files, **more}.items():
                f = out / c.name / name
                f.parent.mkdir(parents=True, exist_ok=True)
                f.write_text(body)
            books["truth"][c.name] = c.truth
            books["details"][c.name] = c.details
    for book, what in books.items():
        (truth_at / f"{book}.json").write_text(json.dumps(what, indent=1))


if __name__ == "__main__":
    main()
