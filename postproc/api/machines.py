"""Machines by name or by folder."""

from __future__ import annotations

from pathlib import Path

from postproc.commands import reading
from postproc.machine import places
from postproc.machine.model import Machine


def machines() -> dict[str, Path]:
    """Every machine that is found, by name, with its folder: ./machines, the user's own, those that come with gcomp."""
    return places.every()


def load_machine(name: str | Path, temperatures: dict[str, float] | None = None) -> Machine:
    """The machine of a name, or of the folder at a path, as `--machine` takes it.

    temperatures: degrees Celsius of scales or screws by axis, and of the work as "work", for machines that state how they
    grow. Raises UsageError with the names that there are, MachineError with file and line of what is wrong in the folder.
    """
    machine = reading.with_control_tables(places.load(str(name)))
    return reading.warmed(machine, dict(temperatures or {}))


def machine_of(machine: Machine | str | Path) -> Machine:
    """What stands for a machine in every function: itself, its name or its folder."""
    return machine if isinstance(machine, Machine) else load_machine(machine)
