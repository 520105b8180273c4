"""What a Python program may use of gcomp; `import gcomp` gives the same names.

Thin: every function does what one command does, with values in place of words, and returns what the
command would print. Nothing is printed and no file is written but by `save`. What a command refuses
is raised as GcompError.
"""

from postproc.api.machines import load_machine, machines
from postproc.api.measurements import (
    Calibrated,
    Diagnosed,
    Evaluated,
    calibrate,
    diagnose,
    evaluate,
    read_recording,
    read_recordings,
)
from postproc.api.programs import Compensated, Settings, Verified, compensate, live_filter, verify
from postproc.errors import GcompError, MachineError, Notice, Place, ProgramError, UsageError
from postproc.filter import Filter
from postproc.machine.model import Machine
from postproc.recordings import Recording

__all__ = [
    "Calibrated", "Compensated", "Diagnosed", "Evaluated", "Filter", "GcompError", "Machine",
    "MachineError", "Notice", "Place", "ProgramError", "Recording", "Settings", "UsageError",
    "Verified", "calibrate", "compensate", "diagnose", "evaluate", "live_filter", "load_machine",
    "machines", "read_recording", "read_recordings", "verify",
]  # fmt: skip
