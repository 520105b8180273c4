"""Machines by name or by folder."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from postproc.commands import reading
from postproc.machine import places
from postproc.machine.model import Machine


def machines() -> dict[str, Path]:
    """Every machine that is found, by name, with its folder: ./machines, the user's own, those that
    come with gcomp."""
    return places.every()


def load_machine(
    name: str | Path, temperatures: dict[str, float] | None = None, only: Sequence[str] = ()
) -> Machine:
    """The machine of a name, or of the folder at a path, as `--machine` takes it.

    temperatures: degrees Celsius of scales or screws by axis, and of the work as "work", for
    machines that state how they grow. only: components (EXX), squareness (C0Y) and effects
    (backlash:X) of the map that shall be corrected, all where it is empty. Raises UsageError with
    the names that there are, MachineError with file and line of what is wrong in the folder.
    """
    asked = argparse.Namespace(
        machine=str(name), temperature=dict(temperatures or {}), only=tuple(only)
    )
    return reading.machine_of(asked)


def machine_of(machine: Machine | str | Path) -> Machine:
    """What stands for a machine in every function: itself, its name or its folder."""
    return machine if isinstance(machine, Machine) else load_machine(machine)
