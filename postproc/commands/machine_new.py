"""`gcomp machines new`: a machine's folder from its options, and from answers where somebody sits
at the keyboard."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from postproc.calibrate import circles, first, square
from postproc.commands import machine_questions, machine_values, option_text, values
from postproc.commands.recording_files import read_files
from postproc.errors import UsageError
from postproc.machine import chain as chains
from postproc.nc import dialects
from postproc.recordings import ReadingOptions, Recording
from postproc.units import URAD

KINDS = "; ".join(f"{name}: {kind.title}" for name, kind in first.KINDS.items())
OPTIONS = f"""
[new] What is not said is asked for where somebody sits at the keyboard. Lengths in mm, X of a lathe
    as a radius.
--kind ({"|".join(first.KINDS)})  {KINDS}
--chain CHAIN  another order: who carries whom, w-b-Y-X-Z-t
--control CONTROL  dialect of its control
--title TITLE  what the machine is, in words
--travel X=0,400 ...  where an axis can be
--least-increment LENGTH  of a word (0.001mm)
--diagonals XY=565.9,565.4,400,400 ...  of a rectangle that the machine made: rising (low to high
    in both axes), falling, side along X, along Y
--drift X/Y=0.05,300 ...  along a square: X drifts by +0.05 while Y goes +300
--ballbar FILE ...  circles in both senses: squareness and lost motion of their axes
--squareness C0Y=120 ...  urad, where it is known
--backlash X=0.05 ...  lost motion by a dial gauge
--scale X=300,300.2 ...  commanded way and measured way
--home X0,Y0,Z0  where the slides stand after homing
--u-length LENGTH  standard uncertainty (k = 1) of each length of --diagonals and --scale, like
    0.2mm; --verify carries it to the path
--u-gauge LENGTH  standard uncertainty (k = 1) of a dial gauge's reading, of --backlash and
    --drift, like 5um
-o, --output FOLDER  where to write it (machines/NAME)
--force  write over a machine folder; the old one stays as .bak
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(
        parser, OPTIONS, title="", travel=machine_values.travel,
        least_increment=(values.length, 0.001), diagonals=machine_values.diagonals,
        drift=machine_values.drift, squareness=machine_values.angle,
        backlash=machine_values.length_of, scale=machine_values.scale, home=(values.place, {}),
        u_length=values.length, u_gauge=values.length,
    )  # fmt: skip


def _travel(options: argparse.Namespace, chain: chains.Chain) -> dict[str, tuple[float, float]]:
    """mm, of every axis. Raises UsageError where one is missing."""
    reach = dict(options.travel)
    for x in chain.axes:
        if x not in reach:
            raise UsageError(f"the travel of {x} is not said", f"--travel {x}=0,400")
    return reach


def _ask(options: argparse.Namespace) -> None:
    """What is missing, of a person at a terminal. Raises UsageError for a machine without a
    name."""
    if sys.stdin is not None and sys.stdin.isatty():
        machine_questions.asked(options)
    if not options.name:
        raise UsageError("how is the machine called?", "gcomp machines new NAME --kind router ...")


def made(options: argparse.Namespace) -> tuple[Path, dict[str, str]]:
    """The folder and its files. Raises UsageError naming what is missing."""
    _ask(options)
    kind = first.KINDS.get(options.kind or "")
    said, chain = _chain(options, kind)
    control = _control(options, kind)
    reach = _travel(options, chain)
    title = f"{options.kind}: {kind.title}" if kind else options.name
    by_circles = _ballbar(options)
    stated = _squareness(options)
    play, scales = dict(options.backlash), dict(options.scale)
    one = first.First(
        name=Path(options.name).name, title=options.title or title, control=control, chain=said,
        travel=reach, least=options.least_increment, diameter=kind.diameter if kind else (),
        square={name: (value, how) for name, (value, how, _) in stated.items()}, backlash=play,
        scale=scales, home=options.home,
        square_u={name: u for name, (_, _, u) in stated.items() if u is not None},
        backlash_u=_of_two(play, options.u_gauge) | by_circles,
        scale_u=_of_two(scales, options.u_length),
    )  # fmt: skip
    _of_chain(one, chain)
    return Path(options.output or f"machines/{one.name}"), first.folder(one)


def _chain(options: argparse.Namespace, kind: first.Kind | None) -> tuple[str, chains.Chain]:
    """As it is said, and read. Raises UsageError for none, and for one that can not be read."""
    said = options.chain or (kind.chain if kind else "")
    if not said:
        raise UsageError(
            "the kind of machine is not said",
            f"--kind {' or '.join(first.KINDS)}, or --chain w-b-Y-X-Z-t",
        )
    try:
        return said, chains.parse(said)
    except ValueError as error:
        raise UsageError(f"--chain: {error}") from None


def _control(options: argparse.Namespace, kind: first.Kind | None) -> str:
    """The name of its dialect. Raises UsageError for none, and for one that there is not."""
    if not options.control:
        usual = f" ({kind.control} is usual on a {options.kind})" if kind else ""
        raise UsageError(
            "its control is not said", f"--control{usual}: {', '.join(dialects.names())}"
        )
    return dialects.load(options.control).name


def _of_two(axes: Iterable[str], u: float | None) -> dict[str, float]:
    """Axis to mm: the standard uncertainty of a difference of two readings, each of u; none where
    nobody said u."""
    return {x: u * math.sqrt(2) for x in axes} if u else {}


def _of_chain(one: first.First, chain: chains.Chain) -> None:
    """Raises UsageError for an axis that the chain has not."""
    for what, given in (
        ("--travel", one.travel),
        ("--backlash", one.backlash),
        ("--scale", one.scale),
        ("--home", one.home),
    ):
        for x in given:
            if x not in chain.axes:
                raise UsageError(
                    f"{what} names {x}, and the chain {one.chain} has none",
                    f"axes: {' '.join(chain.axes)}",
                )
    for name in one.square:
        if not all(x in chain.axes for x in square.pair_of(name)):
            raise UsageError(
                f"squareness {name} is between {' and '.join(square.pair_of(name))}, and the chain"
                f" {one.chain} has not both"
            )


def _ballbar(options: argparse.Namespace) -> dict[str, float]:
    """Adds what circles tell to the squareness and to the lost motion that is not stated; a lost
    motion within its own uncertainty is none. Returns axis to mm, the standard uncertainty of the
    lost motions added. Raises UsageError for a file of another kind, CalibrationError for what is
    no circle."""
    added: dict[str, float] = {}
    planes: dict[str, list[Recording]] = {}
    for one in read_files(options.ballbar, "", ReadingOptions(strict=False)):
        if one.kind != "ballbar":
            raise UsageError(
                f"{one.file} is a {one.kind} recording, no ballbar's", "gcomp calibrate takes it"
            )
        planes.setdefault(circles.axes_of(one), []).append(one)
    for plane, some in planes.items():
        found = circles.fit(some, [np.zeros(len(one)) for one in some])
        name, files = first.name_of(plane[1], plane[0]), " and ".join(found.files)
        how = f"ballbar {files}, u = {found.u['square'] / URAD:.1f} urad"
        options.squareness.append(
            (name, square.sign(name) * found.square, how, lambda _, u=found.u["square"]: u)
        )
        for x, play, u in zip(
            plane, found.play, (found.u["first play"], found.u["second play"]), strict=True
        ):
            # 2 u is U (95 %): a lost motion within it may be none, and would move the slide for
            # nothing
            if x not in dict(options.backlash) and abs(play) > 2 * u:
                options.backlash.append((x, play))
                added[x] = u
    return added


def _squareness(options: argparse.Namespace) -> dict[str, tuple[float, str, float | None]]:
    """Name to rad, how it was found, and its standard uncertainty, rad, None where what
    the lengths are worth is not stated. Raises UsageError for a pair that is said twice."""
    found: dict[str, tuple[float, str, float | None]] = {}
    pairs: dict[str, str] = {}
    for name, value, how, u_of in [*options.squareness, *options.drift, *options.diagonals]:
        pair = square.pair_of(name)
        if pair in pairs:
            raise UsageError(
                f"the squareness of {pair} is said twice: {pairs[pair]} and {how}", "once"
            )
        pairs[pair], found[name] = how, (value, how, u_of(options))
    return found
