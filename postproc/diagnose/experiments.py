"""Which experiment shows an effect, or tells two of them apart: what to run, in the words of `gcomp
simulate --test`."""

from __future__ import annotations

from postproc.machine.chain import XYZ
from postproc.machine.model import Machine

SHOWS = {  # effect: (experiment, what about it matters)
    "scale": (
        "positioning:{a}",
        "laser along {a}, the beam aligned anew, at two temperatures of the screw",
    ),
    "pitch_shape": ("positioning:{a}", "laser along {a} with twice as many targets"),
    "backlash": ("staircase:{a}", "reversals of {a} by 0.01 to 5 mm at one place"),
    "backlash_position": ("positioning:{a}", "laser along {a} in both directions, three runs"),
    "windup": (
        "staircase:{a}",
        "reversals of {a} by 0.01 to 5 mm: windup grows with the way, lost motion does not",
    ),
    "reversal_spike": (
        "ballbar:{p},feed=3000,slow=500",
        "circles at two feeds, sampled every 10 ms or faster",
    ),
    "stick_slip": ("feeds:{a}", "{a} alone at 1 to 50 mm/min, position logged at 100 Hz"),
    "friction_asymmetry": (
        "ballbar:{p},feed=3000,slow=500",
        "circles in both senses at two feeds; log the current of {a}",
    ),
    "servo_lag": (
        "feeds:{a}",
        "{a} alone there and back at two feeds, position logged against the command",
    ),
    "servo_mismatch": (
        "ballbar:{p},feed=3000,slow=500",
        "circles in both senses at two feeds: the ellipse at 45 degrees turns over",
    ),
    "inertia": ("feeds:{a}", "{a} with two accelerations, position logged"),
    "vibration": ("feeds:{a}", "{a} at two feeds: the frequency stays, a cyclic error's does not"),
    "cyclic": (
        "period:{a}",
        (
            "laser along {a} at close targets that are no part of a pitch, over three turns of the"
            " screw"
        ),
    ),
    "encoder_cyclic": (
        "feeds:{a}",
        "{a} slowly over a few periods of the scale, with its own scale and a laser at once",
    ),
    "screw_heat": (
        "positioning:{a}",
        "laser along {a} cold, then after 30 minutes of rapid travel, screw temperature recorded",
    ),
    "structure_drift": (
        "soak:{a}",
        "slides at rest for two hours, reading and temperatures every minute (ISO 230-3)",
    ),
    "spindle_growth": (
        "soak:{a}",
        "spindle on for an hour, off for an hour, reading every minute (ISO 230-3)",
    ),
    "squareness": ("diagonal:{p}", "both diagonals of {p}; a circle in both senses does as well"),
    "bow": ("straightness:{a}", "straightness of {a} with a straightedge that is turned over"),
    "abbe": (
        "arms:{a}",
        (
            "laser along {a} at the same targets on lines as far apart across {a} as the machine"
            " allows; the angle of {a} does as well"
        ),
    ),
    "sag": (
        "positioning:{a}",
        "straightness of the carrying axis with {a} at both ends of its travel",
    ),
    "force_compliance": ("", "the same place with two known weights or forces along {a}"),
    "tool_wear": ("", "five parts, a change of tool, five parts more, all measured"),
    "tool_size": ("", "a boss and a pocket of the same size with the same tool"),
    "step_loss": (
        "positioning:{a}",
        "home {a}, touch the same point again, at the start and at the end",
    ),
    "laser_air": ("positioning:{a}", "the same run with the laser's weather station on"),
    "dead_path": (
        "positioning:{a}",
        "the same run with the interferometer as near to the zero as it goes",
    ),
    "cosine": ("positioning:{a}", "the same run with the beam aligned anew"),
    "delay": (
        "feeds:{a}",
        "all axes there and back at two feeds: a late recording is late in all alike",
    ),
    "coulomb_friction": ("feeds:{a}", "{a} there and back at five feeds with its current recorded"),
    "viscous_friction": ("feeds:{a}", "{a} there and back at five feeds with its current recorded"),
}


NO_CIRCLES = ("heidenhain", "heidenhain-iso")  # their circles hang on a pole
# for a control whose circles gcomp can not read back: what shows the most of the same at rest or in
# a log
WITHOUT_CIRCLES = {
    "servo_mismatch": (
        "diagonal:{p}",
        (
            "both diagonals of {p}, read at rest: what is left of it then is squareness; two feeds"
            " of each axis tell the lag"
        ),
    ),
    "reversal_spike": (
        "feeds:{a}",
        "{a} alone there and back at five feeds, position logged every 10 ms or faster",
    ),
    "friction_asymmetry": ("feeds:{a}", "{a} alone there and back at five feeds; log its current"),
}
APART = (  # names of one set, two of them at least, and the one whose experiment tells them apart
    (("squareness", "servo_mismatch", "servo_lag", "delay"), 2, "servo_mismatch"),
    (("cyclic", "vibration", "encoder_cyclic"), 2, "vibration"),
    (("backlash", "windup", "backlash_position"), 2, "windup"),
    (("structure_drift", "screw_heat", "laser_air", "dead_path"), 2, "structure_drift"),
)
FIRST = (
    "structure_drift", "screw_heat", "windup", "cyclic", "servo_lag", "abbe", "squareness",
    "spindle_growth", "step_loss",
)  # fmt: skip


def showing(effect: str, axis: str, machine: Machine) -> str:
    """The experiment that would show an effect."""
    experiment, words = SHOWS.get(effect, ("positioning:{a}", "more readings along {a}"))
    letters = [x for x in machine.letters if x in XYZ]
    if experiment.startswith("ballbar") and (machine.control in NO_CIRCLES or len(letters) < 2):
        experiment, words = WITHOUT_CIRCLES[effect]
    single = axis[:1] if axis else letters[0]
    other = next((x for x in letters if x != single), single)
    pair = axis if len(axis) == 2 else "".join(sorted(single + other))
    name = experiment.format(a=single, p=pair)
    if not name:
        return words.format(a=single, p=pair)
    file = name.partition(",")[0].replace(":", "_")
    return (
        f"{words.format(a=single, p=pair)}: gcomp simulate --test {name} --machine {machine.name}"
        f" --program-out {file}.nc"
    )


# Whole: a list of rules in their order of precedence.
def separating(key: str, others: list[str], machine: Machine) -> str:
    """The experiment that tells a name from those that explain as well: the one for this set of
    them, else one that shows the first of them by itself."""
    name, _, axis = key.partition(":")
    candidates = [(name, axis), *((n, a) for n, _, a in (o.partition(":") for o in others))]
    # the same effect of another axis: both moved together
    if any(n == name for n, _ in candidates[1:]):
        return (
            "the same with each axis alone:"
            f" {showing('step_loss' if name == 'step_loss' else 'servo_lag', axis, machine)}"
        )
    for names, least, shown in APART:
        alike = [c for c in candidates if c[0] in names]
        # the set's own experiment, along the axes of the one that it shows: a pair for circles
        if name in names and len({n for n, _ in alike}) >= least:
            pair = next((a for _, a in alike if len(a) == 2), axis)
            own = next(
                (a for n, a in alike if n == shown), pair if shown == "servo_mismatch" else axis
            )
            return showing(shown, own, machine)
    best = min(candidates, key=lambda c: FIRST.index(c[0]) if c[0] in FIRST else len(FIRST))
    return showing(*best, machine)
