"""A diagnosis in sentences: what, where, how large, how sure, what to do next."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from postproc.diagnose import words
from postproc.diagnose.answer import Diagnosis, Finding, felt
from postproc.diagnose.drive import Drive
from postproc.diagnose.locate import Place
from postproc.diagnose.summary import UM, fit_of, middle, next_test, rms, scaled

SHOWN, WHERE = 5, 3  # rows of a kind, and regions
PERIODS = 6  # that are written out
NO_HELP = 0.95  # of what is there: what a map takes off is nothing


def as_text(d: Diagnosis, written: str = "") -> str:
    """What a person wants to know: what, where, how large, how sure, what to do next. written:
    the folder into which a machine with the accepted effects was written."""
    lines = [headline(d), ""]
    lines += [f"DOUBT: {text}." for text in d.disagreements]
    for f in d.findings:
        lines += _finding_lines(d, f)
    for place in d.places[:WHERE]:
        lines.append(f"WHERE: {where(d, place)}")
    if len(d.places) > WHERE:
        lines.append(f"WHERE: in {len(d.places) - WHERE} more, --json lists them")
    for one in d.drives:
        lines += drive_lines(one) if one.fitted else []
    if d.unknown:
        lines.append(f"UNKNOWN: {unknown_words(d)}")
    lines += faults(d)
    lines += [f"NOTE: {text}." for text in d.notices]
    lines.append(f"HELD OUT: {held_out_words(d)}.")
    lines += [f"NEXT: {text}" for text in next_steps(d, written)]
    if seen := words.limits(d.limits):
        lines.append(f"Would have been seen from {seen}")
    if d.blind:
        lines.append(f"Can not be seen in these recordings: {words.blind(d.blind)}")
    return "\n".join(lines)


def _finding_lines(d: Diagnosis, f: Finding) -> list[str]:
    """What, how large, how sure, what to do."""
    lines = [f"{f.status.upper()}: {words.named(f.block.key)} ({kind(f)})"]
    for size, interval, meaning in sizes(d, f):
        said = f"{size} ({interval})" if interval else size
        lines.append(f"  {': '.join(part for part in (said, meaning) if part)}")
    lines.append(f"  {worth(d, f)}")
    lines.append(f"  {f.text or f.block.module.TEXT}")
    if f.aliases:
        lines.append(f"  {aliased(f)}")
    if f.equivalent:
        lines.append(
            "  These readings are explained as well by:"
            f" {', '.join(map(words.named, f.equivalent))}."
        )
        lines.append(f"  To tell them apart: {next_test(d, f)}")
    return lines


def aliased(f: Finding) -> str:
    """That the targets stand too evenly for a period to be told, and the way out."""
    said = [f"{p:.4g}" for p in sorted(f.aliases, reverse=True)[:PERIODS]]
    more = len(f.aliases) - len(said)
    periods = " mm, ".join(said) + " mm" + (f" and {more} more" if more else "")
    return (
        f"The targets stand at even distances and show these periods alike: {periods}. Measure at"
        " uneven distances (ISO 230-2) to tell them apart."
    )


def kind(f: Finding) -> str:
    """Whose effect it is, and what may be done with it."""
    module = f.block.module
    return f"of the {module.KIND}; {words.use(module)}"


def sizes(d: Diagnosis, f: Finding) -> list[tuple[str, str, str]]:
    """(size, interval, meaning) of the parameters that say something to a person."""
    t = d.rows.state.time
    span = float(np.ptp(t)) if len(t) else 0.0
    return words.parameters(
        f.block.module, f.value, f.ci95, [Path(r.file).name for r in d.recordings], span
    )


def worth(d: Diagnosis, f: Finding) -> str:
    """How much of the readings it explains, and how sure its name is."""
    part = (f.contribution - middle(d, f.contribution)) * UM
    # about each signal's mean: a set-up zero explains nothing; the signal that shows it best is
    # named
    most = {int(s): rms(part[d.rows.signal == s]) for s in np.unique(d.rows.signal)}
    best = max(most, key=lambda s: most[s])
    # um: two decimals would show 0.00
    if most[best] < 0.005:
        share = "explains no single reading, but their spread"
    else:
        file = Path(d.recordings[int(d.rows.file[d.rows.signal == best][0])].file).name
        others = f", {rms(part):.2f} of all readings" if len(most) > 1 else ""
        share = (
            f"explains {most[best]:.2f} um rms of {file}, {d.rows.signals[best]}{others}; "
            f"{float(np.max(np.abs(part))):.1f} um at most"
        )
    if f.status != "accepted":
        return f"{share}; not to be relied on: something that it does not explain is there as well"
    # beside other members, and at errors of form, a score may fall below what it came in by
    if f.score <= d.least:
        return f"{share}; evidence {f.score:.0f}"
    return (
        f"{share}; evidence {f.score:.0f}, noise alone reaches {d.least:.0f} in 1 % of such"
        " experiments"
    )


def where(d: Diagnosis, place: Place) -> str:
    """One region in which the mismatch stands out, before any effect was taken into account; sizes
    are those of --residuals."""
    way = {"both": "in both directions", "+": "approached in +", "-": "approached in -"}[
        place.approach
    ]
    signal, of_it = d.rows.signals[place.signal], d.rows.signal == place.signal
    part = bool(np.any(d.rows.sees[of_it] == "part"))
    # a soak log: one place, and no direction in which it was reached
    if not np.ptp(d.rows.state.position[place.axis][of_it]):
        way = "at rest"
    at = "" if part else f": {words.stretch(place.axis, place.low, place.high)}, {way}"
    at += f", from {place.times[0]:.0f} to {place.times[1]:.0f} s" if place.timed else ""
    scale, unit = scaled(d, place.signal)
    return (
        f"{Path(d.recordings[place.file].file).name}, {signal}{at}: the machine's file is"
        f" {place.rms * scale:.1f} {unit} rms off there, {place.peak * scale:.1f} {unit} at most"
        f" (chance of noise alone: {words.chance(place.p)})"
    )


def unknown_words(d: Diagnosis) -> str:
    """What no name explains: how large, where, what it goes with, and what its map is worth."""
    u = d.unknown
    if u is None:
        return ""
    file = Path(d.recordings[int(d.rows.file[d.rows.signal == u.signal][0])].file).name
    scale, size = scaled(d, u.signal)
    said = (
        f"{u.rms * scale:.1f} {size} rms in {file}, {d.rows.signals[u.signal]} are there that"
        f" nothing in the library explains. They go with {' and '.join(u.depends)}"
    )
    # the clearest cell alone is named, of those that stand out by two standard errors
    cells = [c for c in u.cells if abs(c.mean) > 2 * c.error]
    if cells and u.depends != ("direction",):
        c = max(cells, key=lambda c: abs(c.mean))
        unit, letter = ("s", "t") if u.along == "time" else ("mm", u.along)
        at = (
            f"{letter} = {c.low:.4g}"
            if f"{c.low:.4g}" == f"{c.high:.4g}"
            else f"{letter} from {c.low:.4g} to {c.high:.4g}"
        )
        way = {0: "", 1: ", approached in +", -1: ", approached in -"}[c.approach]
        said += f"; most of it, {c.mean * scale:+.1f} {size}, at {at} {unit}{way}"
    if u.before is None or u.after is None:
        return f"{said}."
    if u.after > NO_HELP * u.before:
        return (
            f"{said}. A map of it predicts nothing of what was held out ({u.before * scale:.2f}"
            f" {size} rms): it does not repeat."
        )
    return (
        f"{said}. A map of it takes what was held out from {u.before * scale:.2f} to"
        f" {u.after * scale:.2f} {size} rms."
    )


def held_out_words(d: Diagnosis) -> str:
    """Before and after on what took no part."""
    fit = fit_of(d)
    if not fit["held_out"]:
        return "nothing, every run was needed; how well this predicts another run is not known"
    within = f"{100 * fit['coverage95']:.0f} % of its readings lie within their 95 % limits"
    before, noise = (
        f"{fit['rms_before_um']:.2f} um rms by the machine's file",
        f"noise {fit['noise_floor_um']:.2f}",
    )
    after = f", {fit['rms_after_um']:.2f} with the effects above" if d.findings else ""
    return f"{fit['held_out']} took no part in this: {before}{after}, {noise}; {within}"


# Whole: a list of sentences, a condition to each.
def next_steps(d: Diagnosis, written: str = "") -> list[str]:
    """What to do now, in order. written: as in `as_text`."""
    accepted = [f for f in d.findings if f.status == "accepted"]
    steps = []
    if d.disagreements:
        steps.append("see to what DOUBT says and record again.")
    if any(f.equivalent for f in accepted):
        steps.append("run the test that tells the names apart before anything is changed.")
    if uneven := [words.named(f.block.key) for f in accepted if f.aliases]:
        steps.append(f"measure {', '.join(uneven)} at targets at uneven distances (ISO 230-2).")
    if at_fault := [words.named(f.block.key) for f in accepted if f.block.module.KIND != "machine"]:
        steps.append(
            f"correct the recording for {', '.join(at_fault)}, or record again without it; leave"
            " the machine as it is."
        )
    if any(
        f.block.module.KIND == "machine" and hasattr(f.block.module, "coefficients")
        for f in accepted
    ):
        has = f"{written} holds" if written else "--write-machine FOLDER writes"
        steps.append(
            f"{has} a machine with the accepted effects; record again and diagnose with it: nothing"
            " should be left."
        )
    if d.verdict == "nothing-left-out" and d.places:
        steps.append("record the same again: what comes back at the same places is no chance.")
    if d.unknown:
        steps.append(
            "look at the map of what is unknown (--report draws it, --json holds it), and record"
            " the same again: does it come back?"
        )
    return steps


def faults(d: Diagnosis) -> list[str]:
    """A line for every row that was left out; of many alike in a file the first few and their
    number."""
    alike: dict[tuple[int, str], list[tuple[int, float]]] = {}
    for file, line, what, size in d.faults:
        alike.setdefault((file, what), []).append((line, size))
    result = []
    for (file, what), rows in alike.items():
        for line, size in rows[:SHOWN]:
            off = f", {size * UM:.3g} um off" if size else ""
            # the row is still there, only its channel is not
            left = "" if what.endswith("not recorded") else "; left out"
            result.append(f"DATA: {d.recordings[file].file}:{line}: {what}{off}{left}")
        if len(rows) > SHOWN:
            result.append(
                f"DATA: {d.recordings[file].file}: {what}: {len(rows) - SHOWN} rows more, --json"
                " lists them"
            )
    return result


def headline(d: Diagnosis) -> str:
    """The verdict in one sentence."""
    if d.verdict == "left-out-physics":
        found = [words.named(f.block.key) for f in d.findings if f.status == "accepted"]
        found += [
            f"{t.term.name} of {one.axis} (in its {'force' if one.unit == 'N' else 'current'})"
            for one, t in felt(d)
        ]
        beyond = ", and something that the library can not name" if d.unknown else ""
        return f"The model of {d.machine.name} leaves out: {', '.join(found)}{beyond}."
    if d.disagreements:
        return (
            f"No answer for {d.machine.name} can be trusted: these recordings do not fit it, or"
            " each other."
        )
    if d.verdict == "unknown":
        return f"The model of {d.machine.name} leaves something out that the library can not name."
    if d.places:
        return (
            f"No effect is left out of the model of {d.machine.name} that these readings could"
            " name, yet they depart from it in places by more than noise does, see WHERE."
        )
    return (
        f"Nothing is left out: the model of {d.machine.name} explains these readings within their"
        " noise."
    )


def drive_lines(one: Drive) -> list[str]:
    """What one axis' force or current asks for, a line for each term."""
    lines = [
        f"DRIVE of {one.axis}, {one.signal}: {one.raw:.3g} {one.unit} rms while it moves; halves"
        f" that took no part are told to {one.plain:.3g} with inertia, viscous and dry friction, to"
        f" {one.after:.3g} with all of this:"
    ]
    for f in one.fitted:
        said = []
        for name, v in f.value.items():
            size, low, high = words.number(v, *f.ci95[name])
            said.append(f"{name} = {size} (95 %: {low} to {high})" if low else f"{name} = {size}")
        lines.append(
            f"  {f.term.label} ({f.term.name}): {', '.join(said)}; held out {f.before:.3g} ->"
            f" {f.after:.3g} {one.unit}"
            + (", which a delay between force and motion explains as well" if f.delayed else "")
        )
    if one.refused:
        lines.append(f"  not asked for: {', '.join(one.refused)}")
    return lines
