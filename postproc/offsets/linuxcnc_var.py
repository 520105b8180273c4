"""LinuxCNC's parameter file (`rs274ngc.var`, `linuxcnc.var`): a number and a value in a line.

5221-5229 are G54 in X Y Z A B C U V W and 5230 its rotation about Z; G55 follows at 5241, and so on
to G59.3 at 5381. 5210 says whether the shift of G92 and G52 (they share it) in 5211-5219 is in
force; 5220 which system is. Lengths are machine units: [TRAJ]LINEAR_UNITS of the INI file. X is a
radius whatever G7 or G8 says: the interpreter halves a diameter before it stores it. A place is
program word + G92 shift + offset.

Source: LinuxCNC, src/emc/rs274ngc/interp_parameter_def.hh, rs274ngc_pre.cc (init),
interp_convert.cc (convert_axis_offsets); docs/src/gcode/coordinates.adoc.
"""

from __future__ import annotations

import re

from postproc.offsets import AXES, ROTARY, Offsets, Source

TITLE = "LinuxCNC parameter file"
SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
SHIFT_ON, SHIFT, ACTIVE, FIRST, STEP = 5210, 5211, 5220, 5221, 20
LINE = re.compile(r"([0-9]{1,5})\s+(\S+)")
LOOK = re.compile(r"5[23][0-9][0-9]\s+[-+.0-9][-+.0-9eE]*")
ADVICE = "a line is a parameter's number and its value, as LinuxCNC writes them"


def recognises(source: Source) -> bool:
    """Whether a line is a parameter from 5200 to 5399 with a value."""
    return any(LOOK.fullmatch(line) for _, line in source.lines())


def _parameters(source: Source) -> dict[int, float]:
    """Values by number. Raises UsageError."""
    value: dict[int, float] = {}
    for number, line in source.lines():
        found = LINE.fullmatch(line)
        if not found:
            raise source.fault(number, "this is not a parameter with its value", ADVICE)
        parameter = int(found[1])
        if parameter in value:
            raise source.fault(
                number, f"parameter {parameter} stands twice", "keep the one that is true"
            )
        # Values of parameters that are no offsets may be any size.
        # below 5210 stand user parameters, probe results, tool data: not offsets, and of any size
        wanted = parameter >= SHIFT_ON
        value[parameter] = source.number(number, found[2]) if wanted else 0.0
    return value


def read(source: Source) -> Offsets:
    """Work offsets, their rotations, and the shift of G92 if it is in force. Raises UsageError."""
    value = _parameters(source)
    offsets = Offsets(notices=source.unit_notice())
    if source.diameter:
        offsets.notices.append("LinuxCNC stores X as a radius: it is read as one")
    for i, name in enumerate(SYSTEMS):
        if place := _place(value, FIRST + STEP * i, source.scale()):
            offsets.work[name] = place
        #    5221 .. 5229   X Y Z A B C U V W of G54        next system 20 further on
        #    5230           its rotation about Z
        if angle := value.get(FIRST + STEP * i + len(AXES), 0.0):
            offsets.rotation[name] = angle
    shift = _place(value, SHIFT, source.scale())
    if any(shift.values()):
        if value.get(SHIFT_ON):
            offsets.work["G92"] = shift
        else:
            offsets.notices.append(
                "a shift of G92 or G52 is stored and not in force (5210 is 0): left out"
            )
    active = int(value.get(ACTIVE, 1))
    if active != 1 and 1 <= active <= len(SYSTEMS):
        offsets.notices.append(
            f"{SYSTEMS[active - 1]} is in force when the control starts (5220 is {active})"
        )
    return offsets


def _place(value: dict[int, float], first: int, scale: float) -> dict[str, float]:
    """Axis to mm (degrees) of nine parameters from `first` on, those that are there."""
    return {
        axis: value[first + i] * (1.0 if axis in ROTARY else scale)
        for i, axis in enumerate(AXES)
        if first + i in value
    }
