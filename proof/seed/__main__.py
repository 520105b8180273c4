"""The worked story: from the thesis' tables to the named suspects of its unexplained rest, and what
the data can not decide.

    python -m proof.seed [-o FOLDER] [--no-figures]

Writes the tables as recordings, diagnoses them against machines without tables, prints the story,
draws three figures.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from postproc import recordings
from postproc.diagnose import report
from postproc.diagnose.analysis import diagnose
from postproc.diagnose.answer import Diagnosis
from postproc.machine.file import read_machine
from proof.seed import experiment, suspects


def diagnosed(paths: list[Path], machine: str) -> Diagnosis:
    """Recordings against one of the machines without tables."""
    read = [recordings.read(recordings.Source(str(p), p.read_bytes())) for p in paths]
    return diagnose(read, read_machine(experiment.MACHINES[machine]))


def story(folder: Path) -> tuple[list[str], Diagnosis, Diagnosis]:
    """The lines, and what was diagnosed of the grinder and of the parts."""
    paths = experiment.write(folder)
    grinder = diagnosed([paths[name] for name in experiment.READINGS], "grinder")
    parts = diagnosed([paths["parts"]], "mill")
    lines = ["THE GRINDER: Tables 6.1 and 6.2 against a Studer S-36 without any table", ""]
    lines += [line.replace(f"{folder}/", "") for line in report.as_text(grinder).splitlines()[:-2]]
    lines += [
        "",
        "THE REST: 29.5 um on the diagonal, which the thesis could not explain",
        "",
        *suspects.lines(grinder),
    ]
    lines += ["", "THE PARTS: Table 7.3 against an MV-1060 without any table", ""]
    lines += [line.replace(f"{folder}/", "") for line in report.as_text(parts).splitlines()[:-1]]
    lines += ["", *suspects.of_parts()]
    return lines, grinder, parts


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "-o",
        metavar="FOLDER",
        help="where recordings and figures go (default: a folder of its own in the temporary ones)",
    )
    parser.add_argument("--no-figures", action="store_true", help="the text alone")
    options = parser.parse_args()
    folder = Path(options.o) if options.o else Path(tempfile.mkdtemp(prefix="gcomp-seed-"))
    lines, grinder, _ = story(folder)
    print("\n".join(lines))
    if not options.no_figures:
        try:
            from proof.seed import figures

            drawn = figures.draw(grinder, folder)
        except ImportError:
            print("\nFigures need matplotlib: pip install 'gcomp[figures]'")
            return
        print("\n" + "\n".join(f"figure: {path}" for path in drawn))


if __name__ == "__main__":
    main()
