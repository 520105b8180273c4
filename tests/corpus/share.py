"""The share of real programs that are corrected: `python -m tests.corpus.share FOLDER` runs `gcomp
--verify` on all of them.

FOLDER holds programs of other people, DIALECT/SOURCE/FILE: the dialect of their control, and where
they come from. They are no part of the project; what is kept of them are the figures (`--write`:
share.csv, from which docs/COVERAGE.md is made; `--add`: with those of programs that are not at hand
any more).
Each is run as its user would: the command line, a machine with 6 m of travel on every axis whose
map is smooth, all offsets stated as zero, home where the control has one. A refusal is answered by
the option that its advice names, each once (--start: each letter).
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import re
import sys
import tempfile
from collections import Counter, defaultdict
from dataclasses import dataclass
from pathlib import Path

from postproc.cli import main as gcomp
from tests.corpus.machines import MAIN, Machines, offsets, write_smooth
from tests.corpus.programs import XYZ
from tests.corpus.run import at_most

FIGURES = Path(__file__).with_name("share.csv")
PAGE = Path(__file__).resolve().parents[2] / "docs" / "COVERAGE.md"
COLUMNS = (
    "source",
    "dialect",
    "programs",
    "corrected",
    "with an option",
    "broken",
    "not in the text",
    "ours",
)
TITLE = "## The share of real programs that are corrected"
SAID = """\
Programs of other people from public repositories and LinuxCNC's examples, long ones with fewer
motions, each as it was measured last; without a repository's name each program is a source. `python
-m tests.corpus.share` runs `gcomp --verify`: 6 m of travel, a smooth two-way map, all offsets zero,
home stated, 1 um; a refusal is answered by the option that its advice names.

*none*: no dialect here (MillMaster, Acramatic, PAL, Sinumerik 8, Fagor lathe). *Broken*: the
control would stop too. *Not in the text*: only the machine knows it (probing, stored variables, its
builder's codes, axes other than X Y Z A B C), or it is a template.

Lathes have X Z, where a program names Y or C X Y Z C; an offset that no list has (T0203, G30) is
stated as zero too. Some refusals of turning programs were judged by hand (a missing shape or
subprogram; a corner where the shape goes straight on; a Haas shape of type I that turns back; G70
in its own shape; decimal commas; a sum without = on an Okuma; G28 in the shape of G70; G76.55; a
shape that turns back; a remark behind a star), and fourteen of mills (R in a block of M02; a line
of another control; lines of points, twice, of stars; a number with two points, twice; 50 mm above
the reference point, in G91; Z behind a tool change, twice; a home that the control holds; the tool
that #4120 holds; a name that another program sets; RND with RL).

Of programs that nobody has looked at before, expect less: of 103, 69 of 93 legitimate ones were
corrected before anything was mended for them (74 %; of Fanuc lathes 3 of 15, many by students; of
the 61 for other controls than these and Fanuc mills 57). Of 43 more, most of them short, 29 of
31 were, and of one more the blocks behind a sender's `%` were left as they stood, without a
word. Of 22 turning programs (Fanuc, Haas) since then all 16 legitimate ones were, of
LatheEasyStep's 17 for LinuxCNC 11 of 15 (14 now), and of the last 64, all of mills and many cut
short, 46 of 49. Of 119 more from 110 sources, most of them reports of errors in repositories, 85 of
93 (91 %; 89 now), and 85 of the 90 for a control that has a dialect."""
NONE = "none"  # folder of programs whose control has no dialect here
SECONDS = 60
LIVE = {  # axes that a lathe lacked
    "C": re.compile(r"has no axis [CH]\b|no rotary ax|no C in the machine"),
    "YC": re.compile(r"has no axis [YV]\b"),
}
UNSTATED = re.compile(r"--offset (\S+=[XYZ][XYZ0,]*)(?=\s)")
OPTIONS = (  # what an advice names, and what its user would type
    (r"--arc-centre", ("--arc-centre", "absolute")),
    (r"--block-delete", ("--block-delete", "on")),
    (r"--hole-tolerance", ("--hole-tolerance", "20um")),
    (r"--expand", ("--expand",)),
    (r"--start ([A-Z0-9,.]+)", ("--start", "")),  # as the advice writes it
    (r"--outside", ("--outside", "clamp")),
    (r"--integers units", ("--integers", "units")),
    (r"--scaling (\w+) for", ("--scaling", "")),
    (r"say it in mm: --offset (\S+=\S*R5)", ("--offset", "")),
)
BROKEN = (  # an error that the control tells too, or that no control could run
    "is too short: the end lies",
    "is followed by more than a comment",  # LinuxCNC: "Unexpected character after O-word"
    "':' behind the statement",
    " endsub behind this line",  # LinuxCNC: "File ended with no percent sign or program end"
    "is never roughed out",  # LinuxCNC does not end with it
    "below the bottom of the hole at",  # LinuxCNC refuses it too
    "a canned cycle without Y",  # LinuxCNC: "Y value unspecified in xz plane canned cycle"
    "inverse time needs an F word",
    "a depth has no sign",
    "',' or ')' is missing",
    "the arc misses its own end point",
    "in the shape of G150 misses its own end",
    " from the pole",
    "is not text",
    "a comment is opened",
    "the control stops (alarm",
    "words in one block",
    "without its centre words",
    "has no I, K or R",  # the same in a shape
    "is not defined in this program",
    "has no number",
    "no sequence number",
    "there is no block N",
    "an arc of radius 0",
    "WHILE without DO1",
    "calls it unimplemented",
    "is not a code of",
    "a value is missing, or is none",
    "no motion code (G0 G1 G2 G3) is in force",
    "'$' is not part of a plain NC block",
    "'#' is not part of a plain NC block",
)
NOT_THERE = (  # what the text does not say
    "{",
    "[%",
    "(probe)",
    "only the control knows",
    "is known to the control only",
    "the machine has no axis",
    "the machine has no rotary axes",
    "only the machine knows",
    "belongs to the control",
    "a value is missing",
    "there is no program O",
    "there is no sub o",
    "nor a subprogram that it has",
    "beside this one",  # a program that Klartext calls
    "has no value in this program yet",
    "where it ends is known at the machine alone",
    "the program stops itself with the alarm",  # a macro without its arguments
)


@dataclass(frozen=True)
class Result:
    """What became of one program: `corrected`, `with an option` or `refused`, and the sentence that
    refused it."""

    source: str
    dialect: str
    name: str
    status: str
    said: str = ""


def machine_folder(machines: Machines, dialect: str, live: str = "") -> Path:
    """The machine of the corpus with this control, home, and every offset zero; `live`: "C" or
    "YC", further axes of a lathe."""
    folder = machines.folder / (dialect + live)
    if folder.exists():
        return folder
    lathe = "lathe" in dialect
    write_smooth(folder, MAIN.two_way, MAIN.least, lathe, live)
    path = folder / "machine.toml"
    zero = "{ " + ", ".join(f"{x} = 0.0" for x in XYZ if not lathe or x in f"XZ{live}") + " }"
    text = re.sub('control = ".*"', f'control = "{dialect}"\nhome = {zero}', path.read_text())
    path.write_text(text)
    names = {
        **offsets(),
        **{f"{letter}{n}": {} for letter in "HDT" for n in range(100, 1000)},
        **{f"G15 H{n}": {} for n in range(1, 100)},  # Okuma
        **{f"G247 P{n}": {} for n in range(1, 100)},  # Heidenhain
        **{f"G54.1 P{n}": {} for n in range(49, 100)},  # Haas: G154
        **({"G30": {}} if lathe else {}),
    }
    letters = [x for x in offsets()["G54"] if x in (f"XZ{live}".replace("C", "") if lathe else XYZ)]
    rows = [
        ["name", *(f"{x}_mm" for x in letters)],
        *(
            [name, *("0" for _ in letters)]
            for name in names
            if not re.fullmatch("[HDT]0(D1)?", name)
        ),
    ]
    (folder / "offsets.csv").write_text("\n".join(",".join(row) for row in rows) + "\n")
    return folder


def _once(path: Path, folder: Path, more: tuple[str, ...]) -> tuple[bool, str]:
    """Whether `gcomp` accepts a program and verifies it, and what it says."""
    said = io.StringIO()
    with (
        tempfile.TemporaryDirectory() as out,
        contextlib.redirect_stderr(said),
        contextlib.redirect_stdout(said),
    ):
        try:
            with at_most(SECONDS):
                done = (
                    gcomp(
                        [
                            str(path),
                            "--machine",
                            str(folder),
                            "--tolerance",
                            "1um",
                            "--verify",
                            "--offsets",
                            str(folder / "offsets.csv"),
                            "-o",
                            f"{out}/out.nc",
                            *more,
                        ]
                    )
                    == 0
                )
        except SystemExit as stop:
            done = not stop.code
        except TimeoutError:
            return False, f"not done after {SECONDS} s"
    return done, said.getvalue()


def answer(more: tuple[str, ...], option: tuple[str, ...], value: str) -> tuple[str, ...]:
    """The options `more` with one that an advice names, none where it is there already; to --start
    each advice adds another letter."""
    if option[0] not in more:
        return more + tuple(word or value for word in option)
    if option[0] != "--start":
        return ()
    at = more.index("--start") + 1
    if value[0] in more[at]:
        return ()
    return (*more[:at], f"{more[at]},{value}", *more[at + 1 :])


def measure(path: Path, source: str, dialect: str, machines: Machines) -> Result:
    """One program; again on a lathe with the axes that it names, with each offset that no list has,
    and with each option that an advice names."""
    if dialect == NONE:
        return Result(source, dialect, path.name, "refused", "there is no dialect of its control")
    lathe, live = "lathe" in dialect, ""
    stated: tuple[str, ...] = ()
    more: tuple[str, ...] = ()
    while True:
        folder = machine_folder(machines, dialect, live)
        done, said = _once(path, folder, stated + more)
        if done and more:
            return Result(source, dialect, path.name, "with an option", " ".join(more))
        if done:
            return Result(source, dialect, path.name, "corrected")
        axes = next((x for x, lacks in LIVE.items() if lathe and lacks.search(said)), live)
        if len(axes) > len(live):
            live, more = axes, ()
        elif (name := UNSTATED.search(said)) and name[1] not in stated:
            stated += ("--offset", name[1])  # a number of tool and offset that no list has: T0203
        else:
            asked = ((re.search(sign, said), option) for sign, option in OPTIONS)
            answers = (answer(more, o, m[1] if m.groups() else "") for m, o in asked if m)
            found = next((added for added in answers if added), None)
            if found is None:
                break
            more = found
    return Result(source, dialect, path.name, "refused", said)


def kind(result: Result) -> str:
    """Whose the refusal is: `broken`, `not in the text` or `ours`."""
    if any(sign in result.said for sign in BROKEN):
        return "broken"
    return "not in the text" if any(sign in result.said for sign in NOT_THERE) else "ours"


def figures(results: list[Result]) -> list[dict[str, str]]:
    """Rows of share.csv."""
    rows: dict[tuple[str, str], Counter[str]] = defaultdict(Counter)
    for r in results:
        counts = rows[r.source, r.dialect]
        counts["programs"] += 1
        counts[r.status if r.status != "refused" else kind(r)] += 1
    return [
        {"source": source, "dialect": dialect, **{c: str(counts[c]) for c in COLUMNS[2:]}}
        for (source, dialect), counts in sorted(rows.items())
    ]


def table(rows: list[dict[str, str]]) -> list[str]:
    """Markdown: shares by dialect, of what is legitimate."""
    each: dict[str, Counter[str]] = defaultdict(Counter)
    for row in rows:
        for name in (row["dialect"], "all"):
            for column in COLUMNS[2:]:
                each[name][column] += int(row[column])
            each[name]["sources"] += 1
    lines = [
        (
            "| dialect | sources | programs | corrected | with an option | broken | not in the text"
            " | refused, legitimate | share of the legitimate |"
        ),
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name in [*sorted(n for n in each if n != "all"), *(["all"] if "all" in each else [])]:
        c = each[name]
        good, legitimate = (
            c["corrected"] + c["with an option"],
            c["programs"] - c["broken"] - c["not in the text"],
        )
        share = f"{100 * good / legitimate:.1f} %" if legitimate else ""
        lines.append(
            f"| {name} | {c['sources']} | {' | '.join(str(c[column]) for column in COLUMNS[2:])} |"
            f" {share} |"
        )
    return lines


def beside(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """These rows, and those of share.csv of other sources or dialects."""
    own = {(row["source"], row["dialect"]) for row in rows}
    with FIGURES.open(newline="") as file:
        kept = [r for r in csv.DictReader(file) if (r["source"], r["dialect"]) not in own]
    return sorted([*rows, *kept], key=lambda r: (r["source"], r["dialect"]))


def section() -> list[str]:
    """Of docs/COVERAGE.md: what was measured last."""
    if not FIGURES.exists():
        return []
    with FIGURES.open(newline="") as file:
        return [TITLE, "", *SAID.splitlines(), "", *table(list(csv.DictReader(file))), ""]


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true", help="keep the figures in share.csv")
    parser.add_argument(
        "--add", action="store_true", help="as --write; other sources stay as they were measured"
    )
    options = parser.parse_args(arguments)
    results = []
    with tempfile.TemporaryDirectory() as made:
        machines = Machines(Path(made))
        for path in sorted(p for p in options.folder.glob("*/*/*") if p.is_file()):
            dialect, source = path.parts[-3], path.parts[-2].replace("__", "/")
            result = measure(path, source, dialect, machines)
            results.append(result)
            if result.status == "refused":
                print(
                    f"{kind(result)}: {dialect} {source} {path.name}\n{result.said.rstrip()}\n",
                    flush=True,
                )
    rows = figures(results)
    print("\n".join(table(rows)))
    if options.add:
        rows = beside(rows)
    if options.write or options.add:
        with FIGURES.open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)
        text = PAGE.read_text()
        head, old, rest = text.partition(TITLE)
        behind = rest[rest.index("\n## ") + 1 :] if old else text[text.index("\n## fanuc") + 1 :]
        before = head if old else text[: text.index("\n## fanuc") + 1]
        PAGE.write_text(before + "\n".join(section()) + "\n" + behind)
    return 0


if __name__ == "__main__":
    sys.exit(main())
