"""A diagnosis as other programs read it (format gcomp-diagnosis/1), as a person does, and reading by reading."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from postproc.diagnose.answer import Diagnosis, Finding, felt, floor
from postproc.diagnose.drive import Drive, Fitted
from postproc.diagnose.experiments import separating, showing

FORMAT = "gcomp-diagnosis/1"
UM = 1e3
MAP = ("from", "to", "approach", "readings", "residual_um", "u_um")
SHOWN = 5  # rows of a kind in the answer for a person


def as_json(d: Diagnosis, data: list[bytes]) -> dict[str, Any]:
    """The contract's document. data: the bytes of the recordings."""
    return {
        "format": FORMAT,
        "machine": d.machine.name,
        "recordings": [
            {"file": r.file, "sha256": hashlib.sha256(raw).hexdigest(), "rows": len(r)}
            for r, raw in zip(d.recordings, data, strict=True)
        ],
        "verdict": d.verdict,
        "mismatch": [_mismatch(d, place) for place in d.places],
        "effects": [*(_effect(d, f) for f in d.findings), *(_felt(one, term) for one, term in felt(d))],
        "not_visible": [
            {"effect": name, "axis": axis or None, "why": why, "next_test": showing(name, axis, d.machine)}
            for name, axis, why in d.blind
        ],
        "detection_limits_um": {key: _round(size * UM) for key, size in sorted(d.limits.items())},
        "unknown": _unknown(d),
        "data_faults": [
            {"recording": d.recordings[file].file, "row": line, "fault": what, "size_um": _round(size * UM)}
            for file, line, what, size in d.faults
        ],
        "fit": fit_of(d),
        "doubts": d.doubts,
        "notices": d.notices,
        "drives": [_drive(one) for one in d.drives],
    }  # fmt: skip


def fit_of(d: Diagnosis) -> dict[str, Any]:
    """Before, after and the noise floor, of runs that took no part; None where every run was needed."""
    if not d.held.any():
        return {
            "held_out": None,
            "rms_before_um": None,
            "rms_after_um": None,
            "noise_floor_um": None,
            "coverage95": None,
        }
    which = d.held
    return {
        "held_out": d.held_name,
        "rms_before_um": _round(rms(d.before[which]) * UM),
        "rms_after_um": _round(rms(d.after[which]) * UM),
        "noise_floor_um": _round(rms(floor(d)[which]) * UM),
        "coverage95": _round(float(np.mean(np.abs(d.after[which]) <= 1.96 * d.sigma[which]))),
    }


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def _mismatch(d: Diagnosis, place) -> dict[str, Any]:
    return {
        "recording": d.recordings[place.file].file, "signal": d.rows.signals[place.signal], "rms_um": _round(place.rms * UM),
        "peak_um": _round(place.peak * UM), "p_value": place.p,
        "where": {
            "axis": place.axis, "from_mm": _round(place.low), "to_mm": _round(place.high), "approach": place.approach,
            "runs": list(place.runs), "t_from_s": _round(place.times[0]), "t_to_s": _round(place.times[1]),
            "lines": list(_lines(d, place)), "rows": list(place.lines),
        },
    }  # fmt: skip


def _lines(d: Diagnosis, place) -> tuple[int, int]:
    """Lines of the program where the recording knows them, else of the recording."""
    return place.program if "line" in d.recordings[place.file].columns and place.program else place.lines


def _effect(d: Diagnosis, f: Finding) -> dict[str, Any]:
    module = f.block.module
    pieces = f.block.columns.shape[1]
    return {
        "effect": f.block.name, "axis": f.block.axis or None, "kind": module.KIND, "use": module.USE, "status": f.status,
        "parameters": {
            name: {"value": _round(v, 6), "ci95": [_round(e, 6) for e in f.ci95[name]]} for name, v in f.value.items()
        },
        "rms_explained_um": _round(rms(f.contribution - _middle(d, f.contribution)) * UM),
        "p_value": float(f"{chance(f.delta_chi2, pieces):.3g}"),
        "evidence": {"delta_chi2": _round(f.delta_chi2), "score": _round(f.score), "threshold": _round(d.least)},
        "equivalent": f.equivalent,
        "next_test": _next_test(d, f),
        "text": f.text or module.TEXT,
    }  # fmt: skip


def _terms(term: Fitted) -> dict[str, Any]:
    return {
        name: {"value": _round(v, 6), "ci95": [_round(e, 6) for e in term.ci95[name]]} for name, v in term.value.items()
    }


def _felt(one: Drive, term: Fitted) -> dict[str, Any]:
    """What a force or a current shows, as an effect: its size in the unit of that signal, nothing in um."""
    return {
        "effect": term.term.name, "axis": one.axis, "kind": "machine", "use": "simulate", "status": "accepted",
        "parameters": _terms(term), "rms_explained_um": 0.0, "signal": one.signal, f"rms_explained_{one.unit}": _round(term.rms),
        "p_value": float(f"{chance(term.delta_chi2, len(term.ci95)):.3g}"), "evidence": {"delta_chi2": _round(term.delta_chi2)},
        "equivalent": [], "next_test": None, "text": term.term.text,
    }  # fmt: skip


def _drive(one: Drive) -> dict[str, Any]:
    """One axis' force or current: every term, and what halves that took no part are told by."""
    return {
        "axis": one.axis, "signal": one.signal, "unit": one.unit, "files": list(one.files), "samples": one.samples,
        "rms": _round(one.raw), "held_out_plain": _round(one.plain), "held_out_all": _round(one.after),
        "terms": [
            {
                "term": f.term.name, "what": f.term.label, "parameters": _terms(f), "rms": _round(f.rms),
                "delta_chi2": _round(f.delta_chi2), "held_out_before": _round(f.before), "held_out_after": _round(f.after),
            }
            for f in one.fitted
        ],
        "not_asked_for": list(one.refused),
    }  # fmt: skip


def _drive_lines(one: Drive) -> list[str]:
    lines = [
        f"DRIVE of {one.axis}, {one.signal}: {one.raw:.3g} {one.unit} rms while it moves; halves that took no part are told to "
        f"{one.plain:.3g} with inertia, viscous and dry friction, to {one.after:.3g} with all of this:"
    ]
    for f in one.fitted:
        values = ", ".join(
            f"{n} = {v:.4g} ({f.ci95[n][0]:.4g} to {f.ci95[n][1]:.4g})"
            if f.ci95[n][1] > f.ci95[n][0]
            else f"{n} = {v:.4g}"
            for n, v in f.value.items()
        )
        lines.append(f"  {f.term.name}, {f.term.label}: {values}; held out {f.before:.3g} -> {f.after:.3g} {one.unit}")
    lines.append(f"  not asked for: {', '.join(one.refused)}")
    return lines


def _next_test(d: Diagnosis, f: Finding) -> str | None:
    """What tells a finding from what explains as well; None where nothing does."""
    return (f.next_test or separating(f.block.key, f.equivalent, d.machine)) if f.equivalent else None


def _middle(d: Diagnosis, values: np.ndarray) -> np.ndarray:
    """(N,) each signal's mean: a set-up zero that explains nothing. A feature of a part has none."""
    result = np.zeros(len(values))
    for signal in np.unique(d.rows.signal):
        which = (d.rows.signal == signal) & (d.rows.sees != "part")
        if not which.any():
            continue
        result[which] = values[which].mean()
    return result


def chance(fall: float, pieces: int) -> float:
    """Probability that noise alone makes chi squared of so many columns fall by as much."""
    from scipy.special import gammaincc

    return float(max(gammaincc(pieces / 2, max(fall, 0.0) / 2), 1e-300))


def _unknown(d: Diagnosis) -> dict[str, Any] | None:
    if d.unknown is None:
        return None
    u = d.unknown
    which = d.rows.signal == u.signal
    where = next((p for p in d.places if p.signal == u.signal), None)
    return {
        "recording": d.recordings[int(d.rows.file[which][0])].file, "signal": d.rows.signals[u.signal],
        "rms_um": _round(u.rms * UM), "share_left": _round(u.share), "where": _mismatch(d, where)["where"] if where else None,
        "map": map_name(d), "depends_on": list(u.depends), "along": u.along,
        "held_out_rms_before_um": None if u.before is None else _round(u.before * UM),
        "held_out_rms_after_um": None if u.after is None else _round(u.after * UM),
        "table": [dict(zip(MAP, row, strict=True)) for row in _map_rows(d)],
    }  # fmt: skip


def map_name(d: Diagnosis) -> str:
    """Of the map of what is left."""
    return f"unknown_{d.unknown.signal + 1}" if d.unknown else ""


def _map_rows(d: Diagnosis) -> Iterator[tuple]:
    for c in d.unknown.cells if d.unknown else ():
        yield _round(c.low, 6), _round(c.high, 6), c.approach, c.rows, _round(c.mean * UM), _round(c.error * UM)


def unknown_csv(d: Diagnosis) -> str:
    """The map of what is left as a table: something to look at; no compensator applies it."""
    along = "t_s" if d.unknown and d.unknown.along == "time" else f"{d.unknown.along}_mm" if d.unknown else ""
    rows = [",".join([f"{along}_from", f"{along}_to", *MAP[2:]])]
    return "\n".join([*rows, *(",".join(str(v) for v in row) for row in _map_rows(d))]) + "\n"


def _round(value: float, digits: int = 4) -> float:
    """So many significant digits; a number that JSON knows."""
    if not math.isfinite(value):
        return 0.0 if math.isnan(value) else math.copysign(1e300, value)
    return float(f"{value:.{digits}g}")


def residual_rows(d: Diagnosis) -> Iterator[str]:
    """Lines of --residuals: every reading that was used."""
    yield "recording,row,signal,measured_um,before_um,after_um,held_out"
    for k in range(len(d.rows)):
        yield (
            f"{d.recordings[d.rows.file[k]].file},{d.rows.line[k]},{d.rows.signals[d.rows.signal[k]]},"
            f"{d.rows.y[k] * UM:.4f},{d.before[k] * UM:.4f},{d.after[k] * UM:.4f},{int(d.held[k])}"
        )


def as_text(d: Diagnosis) -> str:
    """What a person wants to know: what, where, how large, how sure, what to do next."""
    lines = [_headline(d), ""]
    lines += [f"DOUBT: {text}." for text in d.doubts]
    for f in d.findings:
        axis = f" of {f.block.axis}" if f.block.axis else ""
        values = ", ".join(_value(name, v, f.ci95[name], f.block.module) for name, v in f.value.items())
        explained = rms(f.contribution - _middle(d, f.contribution)) * UM
        lines.append(f"{f.status.upper()}: {f.block.name}{axis} ({f.block.module.KIND}; use: {f.block.module.USE})")
        lines.append(f"  {values}; explains {explained:.2f} um rms of all readings")
        lines.append(f"  {f.text or f.block.module.TEXT}")
        if f.equivalent:
            lines.append(f"  These readings are explained as well by: {', '.join(f.equivalent)}.")
            lines.append(f"  To tell them apart: {_next_test(d, f)}")
    for place in d.places[:3]:
        way = {"both": "in both directions", "+": "approached in +", "-": "approached in -"}[place.approach]
        lines.append(
            f"Without it, the mismatch stands out in {d.recordings[place.file].file}, {d.rows.signals[place.signal]}: "
            f"{place.axis} from {place.low:.1f} to {place.high:.1f} mm, {way}, {place.rms * UM:.1f} um rms, "
            f"{place.peak * UM:.1f} um at most (p = {place.p:.3f})"
        )
    for one in d.drives:
        lines += _drive_lines(one) if one.fitted else []
    if d.unknown:
        u = d.unknown
        shown = (
            ""
            if u.before is None or u.after is None
            else f"; a map of it takes runs held out from {u.before * UM:.2f} to {u.after * UM:.2f} um rms"
        )
        lines.append(
            f"UNKNOWN: {u.rms * UM:.1f} um rms in {d.rows.signals[u.signal]} are there that nothing in the library explains. "
            f"They go with {' and '.join(u.depends)}{shown}."
        )
    lines += _faults(d)
    lines += [f"NOTE: {text}." for text in d.notices]
    fit = fit_of(d)
    if fit["held_out"]:
        lines.append(
            f"Held out ({fit['held_out']}): {fit['rms_before_um']:.2f} um rms before, {fit['rms_after_um']:.2f} after, "
            f"noise {fit['noise_floor_um']:.2f}; {100 * fit['coverage95']:.0f} % within 95 % limits"
        )
    best = sorted((size, key) for key, size in d.limits.items() if size < 1.0)
    if best:
        lines.append("Would have been seen from, um: " + ", ".join(f"{key} {size * UM:.1f}" for size, key in best[:20]))
    blind = sorted({f"{name}{':' + axis if axis else ''}" for name, axis, _ in d.blind})
    if blind:
        lines.append(f"Can not be seen in these recordings: {', '.join(blind[:20])}{' ...' if len(blind) > 20 else ''}")
    return "\n".join(lines)


def _faults(d: Diagnosis) -> list[str]:
    """A line for every row that was left out; of many alike in a file the first few and their number."""
    alike: dict[tuple[int, str], list[tuple[int, float]]] = {}
    for file, line, what, size in d.faults:
        alike.setdefault((file, what), []).append((line, size))
    result = []
    for (file, what), rows in alike.items():
        for line, size in rows[:SHOWN]:
            off = f", {size * UM:.3g} um off" if size else ""
            left = "" if what.endswith("not recorded") else "; left out"
            result.append(f"DATA: {d.recordings[file].file}:{line}: {what}{off}{left}")
        if len(rows) > SHOWN:
            result.append(f"DATA: {d.recordings[file].file}: {what}: {len(rows) - SHOWN} rows more, --json lists them")
    return result


def _headline(d: Diagnosis) -> str:
    accepted = [f for f in d.findings if f.status == "accepted"]
    if d.verdict == "left-out-physics":
        found = [f"{f.block.name}{' of ' + f.block.axis if f.block.axis else ''}" for f in accepted]
        names = ", ".join(
            [
                *found,
                *(
                    f"{t.term.name} of {one.axis} (in its {'force' if one.unit == 'N' else 'current'})"
                    for one, t in felt(d)
                ),
            ]
        )
        return f"The model of {d.machine.name} leaves out: {names}."
    if d.doubts:
        return f"No answer for {d.machine.name} can be trusted: these recordings do not fit it, or each other."
    if d.verdict == "unknown":
        return f"The model of {d.machine.name} leaves something out that the library can not name."
    return f"Nothing is left out: the model of {d.machine.name} explains these readings within their noise."


def _value(name: str, value: float, ci: tuple[float, float], module) -> str:
    unit = module.PARAMETERS[name].split(",")[0]
    if ci[1] - ci[0] < 1e-12:
        return f"{name} = {value:.4g}"
    return f"{name} = {value:.4g} ({ci[0]:.4g} to {ci[1]:.4g}) {unit.split(':')[0]}"


def effects_toml(d: Diagnosis, name: str) -> Callable[[str], str]:
    """What makes a machine.toml that of the diagnosed machine: its name, and a section for every accepted effect of the
    machine. Instruments' and data's effects are none of it."""
    sections = []
    for f in d.findings:
        if f.status != "accepted" or f.block.module.KIND != "machine" or not hasattr(f.block.module, "coefficients"):
            continue
        lines = ["", "[[effect]]", f'name = "{f.block.name}"', f'axis = "{f.block.axis}"']
        lines += [f"{key} = {value!r}" for key, value in f.value.items()]
        files = ", ".join(Path(r.file).name for r in d.recordings)
        lines.append(f'source = "diagnosed from {files}"')
        sections.append("\n".join(lines))

    def changed(text: str) -> str:
        renamed = re.sub(r'(?m)^name(\s*)=(\s*)"[^"\n]*"', lambda m: f'name{m[1]}={m[2]}"{name}"', text, count=1)
        return renamed.rstrip("\n") + "\n" + "\n".join(sections) + ("\n" if sections else "")

    return changed
