"""`gcomp accept BEFORE... AFTER...`: the measurement after compensation against the one before."""

from __future__ import annotations

import argparse

from postproc import ports
from postproc.accept import judge, pairing, report
from postproc.commands import as_json, option_text
from postproc.commands.recording_files import read_files, reading_arguments, reading_options
from postproc.iso import Options
from postproc.iso.lines import LINES
from postproc.machine import places

HELP = (
    "compare measurements before and after compensation: what it took out, and whether every sign"
    " is right"
)
EXAMPLE = (
    "gcomp accept x_before.rtl z_before.rtl x_after.rtl z_after.rtl --machine mine --page"
    " accept.html"
)


OPTIONS = f"""
files+ REC  recordings before, then as many after in the same order
--after+ REC  those after, where they are named apart
--machine M  the machine whose map was used: says whether it or the control errs
--commanded  readings after are against what the corrected program commands, not its nominal
    targets (of gcomp simulate its files say so)
--line ({"|".join(LINES)})  reference line of straightness
--json FILE  all of it as JSON ({report.FORMAT}); - for standard output
--report, --page FILE.html  a page with the curves before and after
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(parser, OPTIONS, after=[], line="least-squares", page={"dest": "page"})
    reading_arguments(parser)


def run(options: argparse.Namespace) -> int:
    machine = places.load(options.machine) if options.machine else None
    how = reading_options(options)
    named, apart = (
        read_files(names, options.format, how) for names in (options.files, options.after)
    )
    before, after = pairing.split(named, apart)
    found = [
        judge.outcome(one, other, machine, Options(options.line))
        for one, other in pairing.pairs(before, after, options.commanded)
    ]
    name = machine.name if machine else ""
    print(report.text(found, name), file=as_json.beside(options.json))
    if options.page:
        from postproc.pages import accepted

        ports.write_whole(options.page, accepted.page(found, name).html().encode("utf-8"))
    as_json.put(options.json, report.as_json(found, name))
    return 0
