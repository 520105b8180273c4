"""The questions of `gcomp machines new`: what its options leave open, asked at the keyboard."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from itertools import combinations
from typing import Any

from postproc.calibrate import first
from postproc.commands import machine_values
from postproc.errors import UsageError
from postproc.machine.chain import XYZ
from postproc.nc import dialects


def asked(options: argparse.Namespace) -> None:
    """Fills in what the options leave open, one question each; an empty answer leaves it out."""
    if not options.name:
        options.name = _answer("name of the machine (a folder's name): ", str, needed=True)
    kind = _kind_and_control(options)
    said = options.chain or (kind.chain if kind else "")
    letters = sorted(set(said) & set(XYZ))
    _travel(options, letters)
    if not (options.squareness or options.drift or options.diagonals):
        for a, b in combinations(letters, 2):
            _squareness(options, a, b)
    if not options.backlash:
        for x in letters:
            text = f"lost motion of {x} by a dial gauge, mm (empty: not measured): "
            options.backlash += filter(None, [_answer(text, _of(x, machine_values.length_of))])


def _kind_and_control(options: argparse.Namespace) -> first.Kind | None:
    """The kind, which says the usual control; None where a chain is stated in place of it."""
    if not options.kind and not options.chain:
        for name, one in first.KINDS.items():
            print(f"  {name:<8} {one.title}")
        options.kind = _answer("kind: ", _kind, needed=True)
    kind = first.KINDS.get(options.kind or "")
    if not options.control:
        usual = kind.control if kind else ""
        options.control = (
            _answer(f"control, one of {', '.join(dialects.names())} [{usual}]: ", _control) or usual
        )
    return kind


def _travel(options: argparse.Namespace, letters: list[str]) -> None:
    reach = dict(options.travel)
    for x in letters:
        if x not in reach:
            text = f"travel of {x} from,to in mm, like 0,400: "
            options.travel.append(_answer(text, _of(x, machine_values.travel), needed=True))


def _squareness(options: argparse.Namespace, a: str, b: str) -> None:
    """By the diagonals of a rectangle, or along a square."""
    text = (
        f"diagonals of a rectangle made in {a}{b}: rising,falling,side {a},side {b} (empty:"
        " not measured): "
    )
    if found := _answer(text, _of(a + b, machine_values.diagonals)):
        options.diagonals.append(found)
        return
    text = (
        f"or along a square: drift of {a} in mm, and the way of {b} on which it does,"
        " like 0.05,300 (empty: not measured): "
    )
    options.drift += filter(None, [_answer(text, _of(f"{a}/{b}", machine_values.drift))])


def _kind(text: str) -> str:
    if text not in first.KINDS:
        raise argparse.ArgumentTypeError(f"{text!r} is not one of {', '.join(first.KINDS)}")
    return text


def _control(text: str) -> str:
    try:
        return dialects.load(text).name
    except UsageError as error:
        raise argparse.ArgumentTypeError(error.message) from None


def _of(name: str, read: Callable[[str], Any]) -> Callable[[str], Any]:
    """A reader of an answer, of the option's text NAME=ANSWER."""
    return lambda text: read(f"{name}={text}")


def _answer(question: str, read: Callable[[str], Any], needed: bool = False) -> Any:
    while True:
        try:
            text = input(question).strip()
        except EOFError:
            raise UsageError(
                "the questions were not answered to the end",
                "gcomp machines new --help lists the options",
            ) from None
        if not text and not needed:
            return None
        try:
            if text:
                return read(text)
        except argparse.ArgumentTypeError as error:
            print(f"  {error}")
