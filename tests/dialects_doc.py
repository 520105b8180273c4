"""docs/DIALECTS.md: what gcomp does with the codes of each control, from the tables. `python -m
tests.dialects_doc` writes it."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

from postproc.nc import codes, dialects, pace

ROOT = Path(__file__).parents[1]
DOC = ROOT / "docs" / "DIALECTS.md"


def every() -> list[dialects.Dialect]:
    return [dialects.load(name) for name in dialects.names()]


HEAD = """# Dialects

What gcomp does with the codes of each control: look here before you use it with a control, or when
a code was refused. How to add one: [ADDING](ADDING.md). A G code that stands in no row is refused,
but where a row says that macros pass; an M code passes, with a notice where the dialect does not
know it.

`--dialect NAME` or `control = "NAME"` in machine.toml chooses a dialect; `--dialect auto` goes by
what the program requires and excludes. Generated from `postproc/nc/dialects/NAME.py`, whose first
lines name the sources, by `python -m tests.dialects_doc`.

- **followed**: the code is obeyed, and motions under it are corrected. Beside a contour (G41 G42)
  the map is read at the tool's centre where its radius is stated, else at the programmed place.
- **corrected in place**: the block stays, and its words are corrected: holes of canned cycles, ends
  of threads, taps of lathes, coordinates given to the place where the machine stands.
- **left as it is**: a threading cycle of a lathe. It ends where it began, so all around it is
  corrected; its thread is cut uncorrected, which a notice says.
- **passed**: it goes to the control as it is; where the axes stand behind it is not known until the
  next place.
- **needs --expand**: it is written out as plain blocks first; `gcomp FILE` does so by itself where
  nothing else corrects the program ([DESIGN](DESIGN.md)).
- **refused**: only where a correction depends on the place; a machine without errors passes it.

`home = { X = 0.0, Y = 0.0, Z = 0.0 }` in machine.toml says where the slides stand after homing (mm,
radius): there G28 and `$H` take them, unless `--offset G28=` or G28.1 says otherwise, and there a
program begins on printers and routers. Without it they stand at `--start`, or at an unknown place;
what could not be corrected for that reason is counted in one line.

An F or S whose value only the machine knows (`F#<_hal[feed]>`, `S#5`) moves no axis and passes
where the language has variables. Which axis words are diameters is said by machine.toml
(`diameter`), by G7 G8 or DIAMON DIAMOF.
"""


def _dwell(dialect: dialects.Dialect) -> str:
    """What its letters count (nc/pace.py), and what is not known of them."""
    told = []
    for letter, unit in pace.letters_of_dwell(dialect).items():
        more = " (ms without a point)" if pace.without_a_point(dialect, letter) == 1e-3 else ""
        told.append(f"{letter} in {'s' if unit == 1.0 else 'ms'}{more}")
    word = pace.first_word(dialect)
    return "; ".join([*told, *([pace.UNTIMED[word]] if word in pace.UNTIMED else [])])


def chapter(dialect: dialects.Dialect) -> str:
    """What the page says of one dialect."""
    kinds: dict[str, list[str]] = defaultdict(list)
    refused: dict[str, list[str]] = defaultdict(list)
    for code in dialect.codes:
        if codes.EXPAND in code.refuses:
            kinds["needs --expand"].append(code.word)
        elif code.refuses:
            refused[code.refuses].append(code.word)
        elif code.does in (*codes.CYCLE_KEYS, "set", "set or off", "set or all", "data"):
            kinds["corrected in place"].append(code.word)
        elif code.does in codes.STAY_KEYS:
            kinds["left as it is"].append(code.word)
        elif code.takes and not code.does:
            kinds["passed"].append(code.word)
        else:
            kinds["followed"].append(code.word)
    for number, reason in dialect.m_refuses.items():
        if codes.EXPAND in reason:
            kinds["needs --expand"].append(f"M{number}")
        else:
            refused[reason].append(f"M{number}")
    rows = [
        (kind, _words(kinds[kind]))
        for kind in ("followed", "corrected in place", "left as it is", "passed", "needs --expand")
        if kinds[kind]
    ]
    rows += [(f"refused: {reason}", _words(words)) for reason, words in sorted(refused.items())]
    rows.append(
        (
            "a number without a point",
            "whole units"
            if dialect.integers == "units"
            else f"{dialect.counts} mm or degrees, {dialect.counts / 10} inch"
            if dialect.counts
            else "least increments",
        )
    )
    if 40 in dialect.by_number:
        rows.append(("a dwell's time", _dwell(dialect)))
    rows.append(
        (
            "`;`",
            dialect.grammar.semicolon
            + (f"; `{dialect.block_end}` ends a block" if dialect.block_end else ""),
        )
    )
    rows.append(("`( )`", "comment" if dialect.grammar.parentheses else "arguments"))
    rows.append(
        ("increments", " ".join(f"{u}={x}" for u, x in dialect.increments.items()) or "by G91")
    )
    rows.append(
        (
            "tool lengths",
            ("by T, with its offset" if dialect.tool_offsets else _lengths(dialect)),
        )
    )
    change = "behind T, M6" if dialect.length_letter == "T" else "behind M6"
    if dialect.change_takes:
        unknown = f"{dialect.change_takes} is unknown until it is named"
        rows.append((change, f"{unknown}; in G91 it stands where it stood, but for G28"))
    if dialect.change_returns:
        back = f"{dialect.change_returns} is read where it stood"
        rows.append((change, f"{back}, and put into no rapid before the program names it or feeds"))
    if dialect.length_left_open:
        changed = "its axis is unknown until the program names its place"
        rows.append(("where a tool length changes", changed))
    if dialect.length_modal:
        rows.append(("H by itself", "another length, while G43 or G44 is in force"))
    if dialect.length_lapses:
        away = " ".join(f"G{n // 10}" for n in dialect.length_lapses)
        rows.append((f"behind {away} along the tool", "no length holds until G43 H names it again"))
    rows.append(("arc may miss its end by", _tolerance(dialect)))
    rows.append(
        (
            "variables and loops",
            f"`--expand`, {dialect.language}" if dialect.language else "none that are followed",
        )
    )
    rows.append(("ends with", _words([f"M{n}" for n in dialect.ends]) or "the text"))
    if dialect.carried:
        rows.append(("carried along", " ".join(dialect.carried)))
    rows += _of_printers(dialect)
    table = "\n".join(f"| {what} | {which} |" for what, which in rows)
    return f"## {dialect.name}\n\n{dialect.title}.\n\n| | |\n|---|---|\n{table}\n"


def _of_printers(dialect: dialects.Dialect) -> list[tuple[str, str]]:
    rows = []
    if dialect.homes:
        rows.append(
            (
                "where a program begins",
                "at `home`, or `--start`; feeds before that is known are left and counted",
            )
        )
    if dialect.skips_centre:
        rows.append(("a centre word outside the plane", "0 is passed over"))
    if dialect.grammar.macros:
        rows.append(("names, macros and files", "pass; places are lost behind them, modes stay"))
    rows += [("refused among them", reason) for reason in dialect.macro_refuses]
    return rows


def _lengths(dialect: dialects.Dialect) -> str:
    if dialect.length_letter == "D":
        return "D, at once, of the tool in use: T brings it with D1, M6 once the program has one"
    at_once = dialect.length_letter != "H" or dialect.length_at_once
    return f"{dialect.length_letter}, at once" if at_once else "G43 H"


def _tolerance(dialect: dialects.Dialect) -> str:
    text = f"{dialect.arc_tolerance_mm:.3g} mm"
    if dialect.arc_tolerance_relative:
        most = dialect.arc_tolerance_most_mm
        text += f", or {100 * dialect.arc_tolerance_relative:g} % of the radius up to {most:.3g} mm"
    if dialect.arc_tolerance_inch != 1:
        text += f"; under G20 {dialect.arc_tolerance_inch:g} times as much"
    return text


def _words(words: list[str]) -> str:
    """Codes in their order, runs of them joined: "G54-G59"."""
    order = sorted(
        words,
        key=lambda w: (
            not re.fullmatch(r"[GM][\d.]+", w),
            w[0],
            float(w[1:]) if re.fullmatch(r"[GM][\d.]+", w) else 0,
            w,
        ),
    )
    runs: list[list[str]] = []
    for word in order:
        last = runs[-1][-1] if runs else ""
        joins = (
            re.fullmatch(r"[GM]\d+", word)
            and re.fullmatch(r"[GM]\d+", last)
            and word[0] == last[0]
            and int(word[1:]) == int(last[1:]) + 1
        )
        runs[-1].append(word) if joins else runs.append([word])
    return " ".join(f"{run[0]}-{run[-1]}" if len(run) > 2 else " ".join(run) for run in runs)


def page() -> str:
    return HEAD + "\n" + "\n".join(chapter(dialect) for dialect in every())


if __name__ == "__main__":
    DOC.write_text(page())
