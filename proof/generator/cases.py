"""One case: the design first, then what is hidden in it, then the readings.

What a kind of case changes: how many effects are hidden and from which list; masked asks for large
known geometry, withheld for a design without a group of channels, blind for a test that can not
see. Nothing else depends on it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from proof.generator import blind, designs, files, machines, oracle, physics, twins
from proof.generator.designs import Design
from proof.generator.physics import Effect, Scene, Shift
from proof.generator.readings import Faults, measured, project
from proof.generator.streams import digest, log_uniform, stream
from proof.generator.world import World

KINDS = ("single", "pair", "triple", "null", "adversarial", "alien", "masked", "withheld", "blind")
ADVERSE = (
    "outliers",
    "warming_ballbar",
    "clock_offset",
    "worse_map",
    "missing_dwell",
    "sensor_drift",
)
CONFUSABLE = [
    ("screw_heat", "scale"),
    ("backlash", "windup"),
    ("tool_wear", "spindle_growth"),
    ("laser_air", "screw_heat"),
    ("squareness", "servo_lag"),
    ("squareness", "servo_mismatch"),
    ("backlash", "backlash_position"),
    ("scale", "cosine"),
    ("structure_drift", "spindle_growth"),
    ("servo_lag", "inertia"),
    ("backlash", "reversal_spike"),
    ("bow", "squareness"),
]
WITHHELD = {  # group of channels to the effects that they drive
    "temperature": ("screw_heat", "structure_drift", "laser_air", "dead_path"),
    "force": ("force_compliance",),
    "spindle": ("spindle_growth",),
    "rotation": ("abbe",),
}
RARE = {  # few designs can show them: asked earlier
    "abbe",
    "laser_air",
    "dead_path",
    "spindle_growth",
    "tool_wear",
    "tool_size",
    "force_compliance",
    "encoder_cyclic",
    "delay",
    "clock_skew",
    "coulomb_friction",
    "viscous_friction",
    "alien:speed_product",
    "alien:gib_rock",
    "alien:speed_resonance",
}


@dataclass
class Case:
    """files, follow_up: path to text, as the user gets them; truth: effects in the form of the
    practice answers; details: what else the scorer may want to know."""

    name: str
    files: dict[str, str]
    truth: list[dict]
    details: dict
    follow_up: dict[str, str] = field(default_factory=dict)


@dataclass
class Hidden:
    effect: Effect
    size: float
    rows: oracle.Rows


@dataclass
class Drawn:
    """A case before its readings are taken: what the loop needs to run a program on the true
    machine (scene, hidden)."""

    scene: Scene
    hidden: list[Hidden]
    spot: blind.Spot | None
    faults: Faults
    adverse: list[str]
    group: str | None


def make(seed: object, kind: str, number: int) -> Case:
    """The case of this seed, kind and number: always the same."""
    return _told((seed, kind, number), draw(seed, kind, number))


def draw(seed: object, kind: str, number: int) -> Drawn:
    """The true machine, the experiment and what is hidden, of the case of this seed, kind and
    number."""
    if kind not in KINDS:
        raise ValueError(f"kind {kind!r} is none of {', '.join(KINDS)}")
    words = (seed, kind, number)
    machine = machines.draw(stream(*words, "machine"), masked=kind == "masked")
    drawing = stream(*words, "design")
    spot = blind.draw(drawing, machine) if kind == "blind" else None
    design = spot.design if spot else designs.draw(drawing, machine)
    group = _withhold(stream(*words, "channels"), design) if kind == "withheld" else None
    faults, adverse = Faults(), []
    if kind == "adversarial":
        adverse = _adverse(stream(*words, "adverse"), design)
        faults = _faults(stream(*words, "faults"), adverse)
    factor = 3.0 if "worse_map" in adverse else 1.0
    machine = replace(machine, errors=machines.errors_of(machine, stream(*words, "map"), factor))
    design = replace(design, machine=machine)
    scene = Scene(design, World(design, stream(*words, "room")))
    hidden = _hide(stream(*words, "effects"), scene, kind, spot, group)
    return Drawn(scene, hidden, spot, faults, adverse, group)


def _hide(rng: np.random.Generator, scene: Scene, kind: str, spot, group) -> list[Hidden]:
    if kind in ("null", "adversarial") or (spot and rng.random() < 0.2):
        return []
    everything = physics.names()
    if spot:
        shown = scene.design.tracks[len(scene.design.tracks) - spot.later :]
        found = _find(
            rng,
            scene,
            spot.hidden,
            _wanted(rng),
            [],
            oracle.Oracle(scene.machine, shown),
            axes=[spot.axis],
        )
        return [found] if found else []
    judge = oracle.Oracle(scene.machine, scene.design.tracks)
    if kind == "alien":
        found = _find(rng, scene, physics.unnamed(), _wanted(rng), [], judge)
        return [found] if found else []
    if group:
        names = {n: everything[n] for n in WITHHELD[group]}
        if group == "rotation":
            turning = str(rng.choice(scene.design.moving))
            names = {"abbe": blind.unmeasured_turn(scene.machine, turning, rng)}
        found = _find(rng, scene, names, _wanted(rng), [], judge)
        return [found] if found else []
    count = {"pair": 2, "triple": 3}.get(kind, 1)
    hidden: list[Hidden] = []
    if count > 1 and rng.random() < 0.5:
        first, second = CONFUSABLE[int(rng.integers(len(CONFUSABLE)))]
        for name in (first, second):
            axes = [h.effect.axis[0] for h in hidden if h.effect.axis] or None
            found = _find(
                rng, scene, {name: everything[name]}, _wanted(rng), hidden, judge, axes=axes
            )
            hidden += [found] if found else []
    most = 8.0 if kind == "masked" else 16.0
    for _ in range(count - len(hidden)):
        found = _find(rng, scene, everything, _wanted(rng, most), hidden, judge)
        hidden += [found] if found else []
    return hidden


def _wanted(rng: np.random.Generator, most: float = 16.0) -> float:
    return log_uniform(rng, 2.0, most)


def _find(
    rng: np.random.Generator,
    scene: Scene,
    names: dict[str, Callable],
    wanted: float,
    others: list[Hidden],
    judge: oracle.Oracle,
    axes: list[str] | None = None,
    tries: int = 3,
) -> Hidden | None:
    """An effect whose largest reading in the tracks of the judge is `wanted` um: names come in
    random order, the RARE ones sooner, and the first that stands out of the noise beside the others
    is it; if none does, the one that comes nearest."""
    best: tuple[float, Hidden] | None = None
    at = [scene.design.tracks.index(t) for t in judge.tracks]
    haste = {name: rng.exponential() / (2.5 if name in RARE else 1.0) for name in sorted(names)}
    for name in sorted(haste, key=lambda n: haste[n]):
        for _ in range(tries):
            axis = str(rng.choice(axes or scene.design.moving))
            effect = names[name](scene, axis, stream(int(rng.integers(1 << 62))))
            if effect is None or any(
                (h.effect.name, h.effect.axis) == (effect.name, effect.axis) for h in others
            ):
                continue
            rows = [project(scene.machine, t, effect.on(t)) for t in scene.design.tracks]
            unit = oracle.peak(judge.tracks, [rows[k] for k in at])
            if unit < 1e-9 or wanted / unit > effect.largest:
                continue
            size = wanted / unit * (float(rng.choice([-1.0, 1.0])) if effect.signed else 1.0)
            made = Hidden(effect, size, [r * size for r in rows])
            signals = [[h.rows[k] for k in at] for h in (*others, made)]
            energy = judge.energies(signals)[-1]
            if energy >= oracle.VISIBLE:
                return made
            if best is None or energy > best[0]:
                best = energy, made
    return best[1] if best else None


def _told(words, drawn: Drawn) -> Case:
    seed, kind, number = words
    scene, hidden, spot, faults = drawn.scene, drawn.hidden, drawn.spot, drawn.faults
    adverse, group = drawn.adverse, drawn.group
    design = scene.design
    name = "c" + digest(seed, kind, number, "name").hex()[:8]
    later = spot.later if spot else 0
    first = len(design.tracks) - later
    late = stream(*words, "late").uniform(300, 4000) if "clock_offset" in adverse else 0.0
    late_file = int(stream(*words, "late_file").integers(first))
    case = Case(name, files.machine_files(scene.machine), [], {})
    for k, track in enumerate(design.tracks):
        noise = stream(*words, "noise", k)
        shift = _sum([h.effect.on(track) for h in hidden], [h.size for h in hidden])
        rows = measured(scene.machine, track, shift, noise, faults)
        text = files.recording(
            scene.world,
            track,
            rows,
            shift,
            design.channels,
            noise,
            late=round(late, 1) if k == late_file else 0.0,
            warm=3.0 if "sensor_drift" in adverse and k == late_file else 0.0,
        )
        if k < first:
            case.files[f"r{k + 1}.csv"] = text
        else:
            case.follow_up[f"f{k - first + 1}.csv"] = text
    case.truth = _truth(scene, hidden, range(first))
    case.details = {
        "seed": str(seed),
        "kind": kind,
        "number": number,
        "machine": scene.machine.form,
        "faults": adverse,
        "withheld": group,
        "files": [t.kind for t in design.tracks[:first]],
        "map_um": scene.machine.stated_um,
    }
    if spot:
        case.details["blind"] = {
            "spot": spot.name, "suspects": spot.suspects, "test": spot.test,
            "follow_up": _truth(scene, hidden, range(first, len(design.tracks))),
        }  # fmt: skip
    return case


def _truth(scene: Scene, hidden: list[Hidden], which: range) -> list[dict]:
    """What is hidden, with its size in these files. energy: what stands out of noise, set-up, map
    and the other truths;
    apart: the least of it that another name leaves; twins: names that leave too little to be told
    from the truth here."""
    tracks = [scene.design.tracks[k] for k in which]
    signals = [[h.rows[k] for k in which] for h in hidden]
    if not hidden:
        return []
    judge = oracle.Oracle(scene.machine, tracks)
    energies = judge.energies(signals)
    answers = []
    for j, (h, rows, energy) in enumerate(zip(hidden, signals, energies, strict=True)):
        largest = oracle.peak(tracks, rows)
        # a blind test may show less than 2 um of what it hides
        bands = ((0, 2), (2, 4), (4, 8), (8, 16))
        band = next((f"{low}-{high}" for low, high in bands if largest < high * 0.9999), "8-16")
        apart = energy
        same: list[str] = []
        if energy >= oracle.VISIBLE and not h.effect.name.startswith("alien"):
            left, same = twins.found(scene, judge, h.effect, rows, signals[:j] + signals[j + 1 :])
            apart = min(energy, left)
        answers.append(
            {
                "effect": h.effect.name,
                "axis": h.effect.axis,
                "parameters": {k: float(v) for k, v in h.effect.parameters(h.size).items()},
                "peak_um": round(largest, 3),
                "visible": bool(energy >= oracle.VISIBLE),
                "energy": round(energy, 1),
                "apart": round(apart, 1),
                "twins": same,
                "band": band,
            }
        )
    return answers


def _sum(shifts: list[Shift | None], sizes: list[float]) -> Shift:
    total = Shift()
    for shift, size in zip(shifts, sizes, strict=True):
        if shift is None:
            continue
        grown = shift.times(size)
        for part in ("tool", "scale", "reading", "turn"):
            added, there = getattr(grown, part), getattr(total, part)
            if added is not None:
                setattr(total, part, added if there is None else there + added)
        for x, ampere in grown.current.items():
            total.current[x] = total.current.get(x, 0.0) + ampere
    return total


def _withhold(rng: np.random.Generator, design: Design) -> str:
    """Take a group of channels out of the design, one that something in it depends on."""
    found = ["temperature"] * 2
    pressed = [t for t in design.tracks if np.abs(t.force).max(initial=0.0) > 50]
    if any(
        t.quantity == "displacement" if t.kind == "targets" else t.head["sees"] == "tool"
        for t in pressed
    ):
        found.append("force")
    if any(t.spindle for t in design.tracks if t.kind == "targets"):
        found += ["spindle"] * 2
    if not any(c[1] in machines.ABC for c in design.machine.components()) and any(
        t.kind == "targets" and len(t.moving) == 1 and t.quantity == "displacement"
        for t in design.tracks
    ):
        found.append("rotation")
    group = str(rng.choice(found))
    gone = {
        "temperature": ("air", "bed", "screw"),
        "force": ("force",),
        "spindle": ("spindle",),
        "rotation": (),
    }[group]
    design.channels.update(dict.fromkeys(gone, False))
    return group


def _adverse(rng: np.random.Generator, design: Design) -> list[str]:
    """One fault of the test that this design can have, sometimes two."""
    able = [
        f
        for f in ADVERSE
        if not (f == "warming_ballbar" and not any(t.kind == "ballbar" for t in design.tracks))
        and not (
            f in ("missing_dwell", "sensor_drift")
            and not any(t.kind == "targets" for t in design.tracks)
        )
        and not (f == "sensor_drift" and not (design.channels["air"] or design.channels["screw"]))
        and not (f == "clock_offset" and len(design.tracks) < 2)
    ]
    return [str(f) for f in rng.choice(able, size=2 if rng.random() < 0.2 else 1, replace=False)]


def _faults(rng: np.random.Generator, adverse: list[str]) -> Faults:
    outliers, warming, ringing = (
        rng.uniform(0.02, 0.05),
        rng.uniform(3.0, 12.0),
        rng.uniform(2.0, 5.0),
    )
    return Faults(
        outliers if "outliers" in adverse else 0.0,
        warming if "warming_ballbar" in adverse else 0.0,
        ringing if "missing_dwell" in adverse else 0.0,
    )
