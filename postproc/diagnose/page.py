"""The answer as one HTML page that needs no network: sentences, tables, and figures of what was left before and after."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from postproc.diagnose import prose, words
from postproc.diagnose.answer import Diagnosis, Finding
from postproc.diagnose.summary import next_test

HEAD = """<!doctype html><html lang="en"><meta charset="utf-8"><title>Diagnosis of {name}</title>
<style>body{{font:16px/1.5 sans-serif;max-width:70em;margin:2em auto;padding:0 1em;color:#222}}h2{{margin-top:1.6em}}
figure{{margin:1.5em 0}}figcaption{{color:#555}}svg{{max-width:100%;height:auto}}table{{border-collapse:collapse}}
th,td{{text-align:left;padding:.15em 1em .15em 0;vertical-align:top}}th{{border-bottom:1px solid #999}}
td:first-child{{min-width:6em}}.verdict{{font-size:1.25em}}.tentative{{color:#777}}code{{background:#f2f2f2;padding:0 .2em}}</style>
<h1>Diagnosis of {name}</h1>"""
MATPLOTLIB = "<p>Figures need matplotlib: pip install 'gcomp[figures]'</p>"
COMMAND = "gcomp simulate"


def page(d: Diagnosis) -> str:
    """HTML with the figures in it; without matplotlib the text alone, and how to have figures."""
    parts = [HEAD.format(name=escape(d.machine.name)), f'<p class="verdict">{escape(prose.headline(d))}</p>']
    parts += [f"<p><b>Doubt:</b> {escape(text)}.</p>" for text in d.doubts]
    for f in d.findings:
        parts += _finding(d, f)
    if d.places:
        parts += ["<h2>Where it stands out</h2>", _list(prose.where(d, place) for place in d.places)]
    if d.unknown:
        parts += ["<h2>What no name explains</h2>", f"<p>{escape(prose.unknown_words(d))}</p>"]
    parts += _held_out(d)
    if steps := prose.next_steps(d):
        parts += ["<h2>What to do next</h2>", _list((step[:1].upper() + step[1:] for step in steps), "ol")]
    parts.append("<h2>Figures</h2>")
    try:
        from postproc.diagnose import plots

        drawn = list(plots.figures(d))
    except ImportError:
        drawn = []
        parts.append(MATPLOTLIB)
    parts += [f"<figure>{svg}<figcaption>{escape(caption)}</figcaption></figure>" for caption, svg in drawn]
    parts += _drives(d)
    parts += _limits(d)
    return "\n".join(parts) + "</html>\n"


def _finding(d: Diagnosis, f: Finding) -> Iterator[str]:
    yield f'<section class="{escape(f.status)}"><h2>{escape(f.status.capitalize())}: {escape(words.named(f.block.key))}</h2>'
    yield f"<p>{_sentence(prose.kind(f))} {escape(f.text or f.block.module.TEXT)}</p>"
    yield _table(("size", "sure", "what it is"), prose.sizes(d, f))
    yield f"<p>{_sentence(prose.worth(d, f))}</p>"
    if f.equivalent:
        yield f"<p>These readings are explained as well by: {escape(', '.join(map(words.named, f.equivalent)))}.</p>"
        yield f"<p>To tell them apart: {_with_command(next_test(d, f) or '')}</p>"
    yield "</section>"


def _with_command(text: str) -> str:
    """A test in words, and its command as one to be copied."""
    before, command, rest = text.partition(COMMAND)
    return f"{escape(before)}<code>{escape(command + rest)}</code>" if command and COMMAND not in rest else escape(text)


def _sentence(text: str) -> str:
    return escape(f"{text[:1].upper()}{text[1:]}.")


def _held_out(d: Diagnosis) -> Iterator[str]:
    yield "<h2>Shown on what took no part</h2>"
    yield f"<p>{_sentence(prose.held_out_words(d))}</p>"


def _drives(d: Diagnosis) -> Iterator[str]:
    told = [one for one in d.drives if one.fitted]
    if told:
        yield "<h2>Forces and currents</h2>"
    for one in told:
        head, *terms = prose.drive_lines(one)
        yield f"<p>{escape(head)}</p>"
        yield _list(terms)


def _limits(d: Diagnosis) -> Iterator[str]:
    if words.limits(d.limits):
        yield "<h2>From which size on an effect would have been seen</h2>"
        rows = [part.split(": ", 1) for part in words.limits(d.limits).split("; ") if part]
        yield _table(("from", "effects"), rows)
    if d.blind:
        yield "<h2>What these recordings can not show</h2>"
        yield _table(("effects", "why"), words.by_reason(d.blind))
    if d.faults:
        yield "<h2>Rows with faults</h2>"
        yield _list(text.removeprefix("DATA: ") for text in prose.faults(d))
    if d.notices:
        yield "<h2>Notes</h2>"
        yield _list(f"{text}." for text in d.notices)


def _list(items, kind: str = "ul") -> str:
    return f"<{kind}>" + "".join(f"<li>{escape(text.strip())}</li>" for text in items) + f"</{kind}>"


def _table(head: tuple[str, ...], rows) -> str:
    said = ["<table><tr>" + "".join(f"<th>{escape(h)}</th>" for h in head) + "</tr>"]
    said += ["<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows]
    return "".join(said) + "</table>"
