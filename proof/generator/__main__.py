"""Write concealed cases: python -m proof.generator --seed S --kind single --count 20 -o cases"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from proof.generator.cases import KINDS, Case, make


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m proof.generator", description=__doc__)
    parser.add_argument(
        "--seed",
        required=True,
        help="any word; everything follows from it, the kind and the case's number",
    )
    parser.add_argument("--kind", required=True, choices=KINDS)
    parser.add_argument("--count", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for the cases")
    parser.add_argument(
        "--truth", type=Path, help="folder for what is hidden; default: truth, beside the output"
    )
    options = parser.parse_args()
    truth = options.truth or options.output.resolve().parent / "truth"
    if (
        truth.resolve() == options.output.resolve()
        or options.output.resolve() in truth.resolve().parents
    ):
        parser.error(f"the truth ({truth}) must not lie among the cases ({options.output})")
    for number in range(options.first, options.first + options.count):
        write(make(options.seed, options.kind, number), options.output, truth)


def write(case: Case, output: Path, truth: Path) -> None:
    """A case under output/<name>; its answers into truth.json and details.json, follow-up files
    under truth/follow_up/<name>."""
    for folder, texts in (
        (output / case.name, case.files),
        (truth / "follow_up" / case.name, case.follow_up),
    ):
        for path, text in texts.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text, encoding="utf-8")
    for name, value in (("truth.json", case.truth), ("details.json", case.details)):
        add(truth / name, case.name, value)


def add(path: Path, name: str, value: object) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    known = json.loads(path.read_text()) if path.exists() else {}
    known[name] = value
    path.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
