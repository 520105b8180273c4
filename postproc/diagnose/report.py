"""A diagnosis as other programs read it (format gcomp-diagnosis/1), and reading by reading; see
prose for a person, machine_effects for a machine's file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from postproc.diagnose.answer import Diagnosis, Finding, felt
from postproc.diagnose.drive import Drive, Fitted
from postproc.diagnose.experiments import showing
from postproc.diagnose.locate import Place
from postproc.diagnose.prose import as_text as as_text
from postproc.diagnose.summary import UM, fit_of, middle, next_test, rms, rounded, scaled, shown

FORMAT = "gcomp-diagnosis/1"
MAP = ("from", "to", "approach", "readings", "residual_um", "u_um")


def of_files(d: Diagnosis, digests: dict[str, str]) -> dict[str, Any]:
    """The contract's document of what was read from these files, after the faults that reading
    found have been added to the diagnosis. digests: SHA-256 of each, by its name."""
    # of no size: what could not be read at all has none
    d.faults += [(i, f.line, f.message, 0.0) for i, r in enumerate(d.recordings) for f in r.faults]
    return as_json(d, [digests[r.file] for r in d.recordings])


def as_json(d: Diagnosis, digests: list[str]) -> dict[str, Any]:
    """The contract's document. digests: SHA-256 of the recordings."""
    return {
        "format": FORMAT,
        "machine": d.machine.name,
        "recordings": [
            {"file": r.file, "sha256": digest, "rows": len(r)}
            for r, digest in zip(d.recordings, digests, strict=True)
        ],
        "verdict": d.verdict,
        "mismatch": [_mismatch(d, place) for place in d.places],
        "effects": [
            *(_effect(d, f) for f in d.findings),
            *(_felt(one, term) for one, term in felt(d)),
        ],
        "not_visible": [
            {
                "effect": name,
                "axis": axis or None,
                "why": why,
                "next_test": showing(name, axis, d.machine),
            }
            for name, axis, why in d.blind
        ],
        "detection_limits_um": {key: rounded(size * UM) for key, size in sorted(d.limits.items())},
        "unknown": _unknown(d),
        "data_faults": [
            {
                "recording": d.recordings[file].file,
                "row": line,
                "fault": what,
                "size_um": rounded(size * UM),
            }
            for file, line, what, size in d.faults
        ],
        "fit": fit_of(d),
        "doubts": d.disagreements,
        "notices": d.notices,
        "drives": [_drive(one) for one in d.drives],
    }


def _mismatch(d: Diagnosis, place: Place) -> dict[str, Any]:
    """A place; of angles rms_um and peak_um hold urad, as unit says."""
    scale, unit = scaled(d, place.signal)
    return {
        "recording": d.recordings[place.file].file,
        "signal": d.rows.signals[place.signal],
        "rms_um": rounded(place.rms * scale),
        "peak_um": rounded(place.peak * scale),
        "unit": unit,
        "p_value": place.p,
        "where": {
            "axis": place.axis,
            "from_mm": rounded(place.low),
            "to_mm": rounded(place.high),
            "approach": place.approach,
            "runs": list(place.runs),
            "t_from_s": rounded(place.times[0]),
            "t_to_s": rounded(place.times[1]),
            "lines": list(_lines(d, place)),
            "rows": list(place.lines),
        },
    }


def _lines(d: Diagnosis, place: Place) -> tuple[int, int]:
    """Lines of the program where the recording knows them, else of the recording."""
    return (
        place.program
        if "line" in d.recordings[place.file].columns and place.program
        else place.lines
    )


def _effect(d: Diagnosis, f: Finding) -> dict[str, Any]:
    module = f.block.module
    pieces = f.block.width
    return {
        "effect": f.block.name,
        "axis": f.block.axis or None,
        "kind": module.KIND,
        "use": module.USE,
        "status": f.status,
        "parameters": {
            name: {"value": rounded(v, 6), "ci95": [rounded(e, 6) for e in f.ci95[name]]}
            for name, v in f.value.items()
        },
        "rms_explained_um": rounded(rms(shown(d, f.contribution - middle(d, f.contribution)))),
        # A name is judged by its score beside the threshold; the p-value is that of one test, asked
        # for once, and knows nothing of the other names that were tried.
        "p_value": float(f"{chance(f.delta_chi2, pieces):.3g}"),
        "evidence": {
            "delta_chi2": rounded(f.delta_chi2),
            "score": rounded(f.score),
            "threshold": rounded(d.least),
        },
        "equivalent": f.equivalent,
        "names": {name: rounded(p, 3) for name, p in f.names.items()},
        **({"aliases_mm": [rounded(p, 6) for p in f.aliases]} if f.aliases else {}),
        "next_test": next_test(d, f),
        "text": f.text or module.TEXT,
    }


def _terms(term: Fitted) -> dict[str, Any]:
    return {
        name: {"value": rounded(v, 6), "ci95": [rounded(e, 6) for e in term.ci95[name]]}
        for name, v in term.value.items()
    }


def _felt(one: Drive, term: Fitted) -> dict[str, Any]:
    """What a force or a current shows, as an effect: its size in the unit of that signal, nothing
    in um."""
    return {
        "effect": term.term.name,
        "axis": one.axis,
        "kind": "machine",
        "use": "simulate",
        "status": "accepted",
        "parameters": _terms(term),
        # a force moves no reading: its size stands in its own unit below
        "rms_explained_um": 0.0,
        "signal": one.signal,
        f"rms_explained_{one.unit}": rounded(term.rms),
        "p_value": float(f"{chance(term.delta_chi2, len(term.ci95)):.3g}"),
        "evidence": {"delta_chi2": rounded(term.delta_chi2)},
        "equivalent": [],
        "next_test": None,
        "text": term.term.text,
    }


def _drive(one: Drive) -> dict[str, Any]:
    """One axis' force or current: every term, and what halves that took no part are told by."""
    return {
        "axis": one.axis,
        "signal": one.signal,
        "unit": one.unit,
        "files": list(one.files),
        "samples": one.samples,
        "rms": rounded(one.raw),
        "held_out_plain": rounded(one.plain),
        "held_out_all": rounded(one.after),
        "terms": [
            {
                "term": f.term.name,
                "what": f.term.label,
                "parameters": _terms(f),
                "rms": rounded(f.rms),
                "delta_chi2": rounded(f.delta_chi2),
                "held_out_before": rounded(f.before),
                "held_out_after": rounded(f.after),
            }
            for f in one.fitted
        ],
        "not_asked_for": list(one.refused),
    }


def chance(fall: float, pieces: int) -> float:
    """Probability that noise alone makes chi squared of so many columns fall by as much."""
    # Q(k/2, x/2), the regularised upper incomplete gamma function, is the part of a chi squared
    # distribution of k degrees of freedom beyond x. Not 0: so small a number is a limit of the
    # format.
    from scipy.special import gammaincc

    return float(max(gammaincc(pieces / 2, max(fall, 0.0) / 2), 1e-300))


def _unknown(d: Diagnosis) -> dict[str, Any] | None:
    if d.unknown is None:
        return None
    u = d.unknown
    which = d.rows.signal == u.signal
    # what is unknown has no place of its own: the region that stood out in its signal, if one did
    where = next((p for p in d.places if p.signal == u.signal), None)
    scale, unit = scaled(d, u.signal)
    return {
        "recording": d.recordings[int(d.rows.file[which][0])].file,
        "signal": d.rows.signals[u.signal],
        "rms_um": rounded(u.rms * scale),
        "unit": unit,
        "share_left": rounded(u.share),
        "where": _mismatch(d, where)["where"] if where else None,
        "map": map_name(d),
        "depends_on": list(u.depends),
        "along": u.along,
        "held_out_rms_before_um": None if u.before is None else rounded(u.before * scale),
        "held_out_rms_after_um": None if u.after is None else rounded(u.after * scale),
        "table": [dict(zip(MAP, row, strict=True)) for row in _map_rows(d)],
    }


def map_name(d: Diagnosis) -> str:
    """Of the map of what is left."""
    return f"unknown_{d.unknown.signal + 1}" if d.unknown else ""


def _map_rows(d: Diagnosis) -> Iterator[tuple[Any, ...]]:
    scale = scaled(d, d.unknown.signal)[0] if d.unknown else UM
    for c in d.unknown.cells if d.unknown else ():
        yield (
            rounded(c.low, 6),
            rounded(c.high, 6),
            c.approach,
            c.rows,
            rounded(c.mean * scale),
            rounded(c.error * scale),
        )


def unknown_csv(d: Diagnosis) -> str:
    """The map of what is left as a table: something to look at; no compensator applies it."""
    # the first two columns are named by what the map goes along, with its unit
    along = (
        "t_s"
        if d.unknown and d.unknown.along == "time"
        else f"{d.unknown.along}_mm"
        if d.unknown
        else ""
    )
    rows = [",".join([f"{along}_from", f"{along}_to", *MAP[2:]])]
    return "\n".join([*rows, *(",".join(str(v) for v in row) for row in _map_rows(d))]) + "\n"


def residual_rows(d: Diagnosis) -> Iterator[str]:
    """Lines of --residuals: every reading that was used, um; of angles urad."""
    measured, before, after = (shown(d, v) for v in (d.rows.y, d.before, d.after))
    yield "recording,row,signal,measured_um,before_um,after_um,held_out"
    files, signals = [_cell(r.file) for r in d.recordings], [_cell(s) for s in d.rows.signals]
    for k in range(len(d.rows)):
        yield (
            f"{files[d.rows.file[k]]},{d.rows.line[k]},{signals[d.rows.signal[k]]},"
            f"{measured[k]:.4f},{before[k]:.4f},{after[k]:.4f},{int(d.held[k])}"
        )


def _cell(text: str) -> str:
    """A text as a cell of a table: a feature may be called "hole, left"."""
    if not any(sign in text for sign in ',"\n'):
        return text
    return '"' + text.replace('"', '""') + '"'
