"""Recordings of real machines, one after the other; the table that comes of it.

    python -m proof.real [NAME...] [-o FOLDER] [--quick] [--json FILE] [--page docs/PROOF.md]

--page puts the section into a document, between its marks; where there is no such file it is the
section alone.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path

from proof.real import page
from proof.real.cases import CASES
from proof.real.run import run


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help="these only: " + ", ".join(c.name for c in CASES)
    )
    parser.add_argument(
        "-o",
        metavar="FOLDER",
        help="where recordings, machines and answers go (default: a temporary one)",
    )
    parser.add_argument("--quick", action="store_true", help="without the long logs")
    parser.add_argument("--json", metavar="FILE", help="the results, for other programs")
    parser.add_argument("--page", metavar="FILE", help="put the section into this document")
    options = parser.parse_args()
    unknown = set(options.names) - {c.name for c in CASES}
    if unknown:
        parser.error(f"no such recording: {', '.join(sorted(unknown))}")
    folder = Path(options.o) if options.o else Path(tempfile.mkdtemp(prefix="gcomp-real-"))
    results = []
    for case in CASES:
        if (options.names and case.name not in options.names) or (options.quick and not case.quick):
            continue
        started = time.monotonic()
        result = run(case, folder / case.name)
        if result is None:
            print(f"{case.name}: not here, left out")
            continue
        results.append(result.as_dict())
        word = "yes" if result.verdict else f"NO ({'; '.join(result.reasons)})"
        print(
            f"{case.name}: {word}; {result.first or 'nothing'}; {result.size}"
            f" [{time.monotonic() - started:.1f} s]",
            flush=True,
        )
    if options.json:
        Path(options.json).write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    if options.page:
        if len(results) < len(CASES):
            parser.error("--page wants all recordings")
        document = Path(options.page)
        section = page.page(results)
        if document.exists():
            section = page.put_in(document.read_text(encoding="utf-8"), section)
        document.write_text(section, encoding="utf-8")
    else:
        print("\n" + page.table(results))


if __name__ == "__main__":
    main()
