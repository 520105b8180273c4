"""Whether recordings can be what they say: values that instruments give, rows in the order of time,
axes that follow.

What is wrong with single rows is listed and left out; what is wrong with a recording stops the
diagnosis, with the first row that shows it. Nothing is repaired in silence.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from postproc.diagnose import order, saturation, sensors
from postproc.errors import Place
from postproc.machine.chain import XYZ
from postproc.machine.model import Machine
from postproc.recordings import Recording, RecordingError

FEWEST = {"targets": 8, "ballbar": 32, "trace": 32, "features": 2}  # rows
READS = ("targets", "ballbar")  # kinds with one column of readings
BESIDE = 2  # rows of a recording beside others: what it shows they can bear out
LOST = 1 / 3  # of the rows may be left out
LONGEST = 1e5  # mm: no slide goes farther
LARGEST = 1e5  # um: no machine is off by more
LATEST = 1e9  # s
BEYOND = 0.02  # of the travel: by how much an axis may overrun what its machine's file says
RUNS = 1e9
COVERED = 0.2  # of the travel: places that fit it as another unit cover so much
ROUND = 0.01  # of the radius
UNITS = {
    1000.0: "um or m for mm",
    0.001: "m or um for mm",
    25.4: "mm for inch",
    1 / 25.4: "inch for mm",
    -1.0: "the other sign",
}


@dataclass
class Sound:
    """What is left to be diagnosed: recordings; faults: (file, line, what, mm) of rows that were
    left out; notices: what was taken for granted."""

    recordings: list[Recording]
    faults: list[tuple[int, int, str, float]] = field(default_factory=list)
    notices: list[str] = field(default_factory=list)


def connected(recordings: list[Recording]) -> tuple[list[Recording], list[str]]:
    """Those of several recordings in which the instrument reads at all, and what is said of the
    others; all of them where none does."""
    dead = [r for r in recordings if r.kind in READS and _constant(r)]
    if len(dead) == len(recordings):
        return recordings, []
    said = [
        f"{r.file} is left out: {_reading(r)} = {r.columns[_reading(r)][0]:g} in all {len(r)} rows,"
        " so the instrument was not connected, or the column is another"
        for r in dead
    ]
    return [r for r in recordings if not any(r is d for d in dead)], said


def _reading(recording: Recording) -> str:
    """The column of its readings."""
    if recording.kind == "ballbar":
        return "radial_um"
    return "reading_urad" if recording.quantity == "angle" else "reading_um"


def _constant(recording: Recording) -> bool:
    value = recording.columns[_reading(recording)]
    return len(value) >= FEWEST[recording.kind] and np.ptp(value) == 0


def checked(recordings: list[Recording], machine: Machine) -> Sound:
    """Raises RecordingError for a recording that can not be compared with the machine's file, with
    file and line."""
    result = Sound([])
    for number, recording in enumerate(recordings):
        if recording.kind not in FEWEST:
            raise RecordingError(
                f"{recording.file} is a recording of {recording.kind}, in which no effect is"
                " looked for",
                "gcomp volumetric makes a map of it",
            )
        for earlier in recordings[:number]:
            if _same(earlier, recording):
                raise RecordingError(
                    f"{recording.file} holds the same {len(recording)} rows as {earlier.file}",
                    "name each recording once",
                )
        check = _Check(
            recording,
            number,
            machine,
            result,
            least=FEWEST[recording.kind] if len(recordings) == 1 else BESIDE,
        )
        result.recordings.append(check.whole())
    return result


def _same(one: Recording, other: Recording) -> bool:
    return (
        one.kind == other.kind
        and len(one) == len(other)
        and len(one) >= FEWEST[one.kind]
        and one.columns.keys() == other.columns.keys()
        and one.head.get("sensitive") == other.head.get("sensitive")
        and all(
            np.array_equal(v, other.columns[k]) for k, v in one.columns.items() if v.dtype != object
        )
    )


class _Check:
    """One recording on its way through the checks. r: what is left of it; sound: where faults and
    notices go; least: rows that must be left."""

    def __init__(
        self, recording: Recording, number: int, machine: Machine, sound: Sound, least: int
    ):
        self.r, self.number, self.machine = recording, number, machine
        self.sound, self.least = sound, least
        if len(recording.lines) != len(recording):
            self.r = replace(recording, lines=np.arange(1, len(recording) + 1))

    def whole(self) -> Recording:
        self._axes()
        self._numbers()
        self._sensors()
        if self.r.kind == "features":
            if said := order.named_parts(self.r.columns.get("part", np.zeros(0))):
                self.note(said)
            return self._enough()
        self._ordered()
        self._travel()
        if self.r.kind == "targets":
            self._targets()
        if self.r.kind == "ballbar":
            self._circle()
        if self.r.kind == "trace":
            self._follows()
        if self.r.kind in READS:
            self._alive()
        return self._enough()

    # -- what to say -------------------------------------------------------------------------------

    def at(self, row: int) -> Place:
        return Place(self.r.file, int(self.r.lines[row]))

    def note(self, text: str) -> None:
        self.sound.notices.append(f"{self.r.file}: {text}")

    def without(
        self, bad: np.ndarray, what: str, advice: str, size: np.ndarray | None = None
    ) -> None:
        """Leave rows out and list them. what may hold {value}. Raises RecordingError where too many
        are bad."""
        rows = np.flatnonzero(bad)
        if not len(rows):
            return
        if len(rows) > LOST * len(bad):
            raise RecordingError(
                f"{what}, and so in {len(rows)} of {len(bad)} rows", advice, self.at(int(rows[0]))
            )
        sizes = np.zeros(len(bad)) if size is None else size
        self.sound.faults += [
            (self.number, int(self.r.lines[k]), what, float(sizes[k])) for k in rows
        ]
        self.r = self.r.pick(~bad)

    # -- the checks --------------------------------------------------------------------------------

    # Whole: a list of refusals, a condition to each.
    def _axes(self) -> None:
        for letter in self.r.axes:
            if letter not in self.machine.letters:
                raise RecordingError(
                    f"{self.r.file} records {letter}, which is no axis of {self.machine.name}",
                    f"its axes are {' '.join(self.machine.letters)}",
                )
        if self.r.machine and self.r.machine != self.machine.name:
            self.note(
                f"it was recorded on {self.r.machine}, and is compared with {self.machine.name}"
            )
        along = self.r.sensitive if self.r.kind == "targets" and self.r.quantity != "angle" else {}
        for letter, share in along.items():
            if share and letter in XYZ and letter not in self.machine.letters:
                raise RecordingError(
                    f"the reading is taken along {letter}, which is no axis of {self.machine.name}",
                    f"sensitive names one of {' '.join(self.machine.letters)}",
                    Place(self.r.file, 1),
                )
        if (
            along
            and self.r.quantity == "displacement"
            and not any(along.get(x) for x in self.r.axes)
        ):
            letter = max(along, key=lambda x: abs(along[x]))
            raise RecordingError(
                f"the reading is taken along {letter}, and {letter}_mm is not recorded",
                f"recorded are {', '.join(f'{x}_mm' for x in self.r.axes)}", Place(self.r.file, 1),
            )  # fmt: skip

    def _numbers(self) -> None:
        """Leave out what no machine and no instrument gives."""
        if "run" in self.r.columns:
            run = self.r.columns["run"]
            self.without(
                ~(np.abs(run) < RUNS) | (run != np.round(np.where(np.isfinite(run), run, 0))),
                "run is no whole number", "runs are numbered 1, 2, 3",
            )  # fmt: skip
        for name in self._needed():
            limit, unit = (
                (LARGEST, name.rpartition("_")[2])
                if name.endswith(("_um", "_urad"))
                else (LONGEST, "mm")
            )
            if name == "t_s":
                limit, unit = LATEST, "s"
            value = self.r.columns[name]
            if name == "t_s" and not np.isfinite(value).any():
                self.r = replace(
                    self.r, columns={k: v for k, v in self.r.columns.items() if k != "t_s"}
                )
                self.note("t_s is empty: the order of the rows is taken for that of time")
                continue
            # so that NaN is bad as well
            bad = ~(np.abs(value) <= limit)
            worst = f"{value[np.flatnonzero(bad)[0]]:.3g}" if bad.any() else ""
            self.without(
                bad,
                f"{name} = {worst}, beyond {limit:g} {unit}",
                "look at the column's unit and at the file's export",
            )

    def _needed(self) -> list[str]:
        tails = (
            "_cmd_mm", "_act_mm", "reading_um", "reading_urad", "radial_um", "nominal_mm",
            "measured_mm",
        )  # fmt: skip
        places = {f"{x}_mm" for x in self.r.axes if x in XYZ}
        return [
            n
            for n, v in self.r.columns.items()
            if v.dtype != object and (n.endswith(tails) or n in places or n == "t_s")
        ]

    def _sensors(self) -> None:
        self.r, faults = sensors.readable(self.r)
        self.sound.faults += [(self.number, line, said, 0.0) for line, said in faults]

    def _ordered(self) -> None:
        self.r, copies, notice = order.by_time(self.r)
        if notice:
            self.note(notice)
        self.sound.faults += [
            (self.number, int(line), "a copy of the row before", 0.0) for line in copies
        ]

    def _travel(self) -> None:
        for letter in (x for x in self.r.axes if x in XYZ):
            low, high = self.machine.axes[letter].travel
            if not np.isfinite(high - low):
                continue
            p = self.r.position(letter)
            out = (p < low - BEYOND * (high - low)) | (p > high + BEYOND * (high - low))
            if not out.any():
                continue
            first = int(np.flatnonzero(out)[0])
            fits = [
                words
                for factor, words in UNITS.items()
                if low <= min(p * factor)
                and max(p * factor) <= high
                and np.ptp(p) * abs(factor) > COVERED * (high - low)
            ]
            advice = (
                f"these places fit as {fits[0]}"
                if fits
                else "another machine, another zero, or another unit"
            )
            self.without(
                out,
                f"{letter} = {p[first]:g} mm lies outside the travel of {self.machine.name},"
                f" {low:g} to {high:g} mm",
                advice,
            )

    def _targets(self) -> None:
        self.r, notices = order.approaches(self.r)
        for notice in notices:
            self.note(notice)
        name = _reading(self.r)
        end = saturation.at_an_end(self.r.columns[name], self._place())
        self.without(
            end,
            f"{name} stands at the end of what the instrument can read",
            "a larger range, or a mean position of the optics",
        )
        still = saturation.unchanged(self.r.columns[name])
        self.without(
            still, f"{name} does not change any more", "the instrument hangs, or its beam was cut"
        )

    def _place(self) -> np.ndarray:
        """(N,) number of the place and side of each row; of a circle of the degree and sense."""
        if self.r.kind == "ballbar":
            (x, a), (y, b) = self.r.head["centre"].items()
            turn = np.degrees(np.arctan2(self.r.position(y) - b, self.r.position(x) - a))
            place: np.ndarray = np.round(turn) + 1000 * self.r.columns["sense"]
            return place
        keys = [np.round(self.r.position(x), 2) for x in self.r.axes] + [
            self.r.approach(x) for x in self.r.axes
        ]
        return np.unique(np.stack(keys), axis=1, return_inverse=True)[1].ravel()

    def _circle(self) -> None:
        centre, radius = self.r.head["centre"], self.r.head["radius_mm"]
        if len(centre) != 2:
            raise RecordingError(
                f"the centre is stated in {len(centre)} {'axis' if len(centre) == 1 else 'axes'}",
                "like centre = { X = 400.0, Y = 300.0 }", Place(self.r.file, 1),
            )  # fmt: skip
        away = np.sqrt(sum((self.r.position(x) - c) ** 2 for x, c in centre.items()))
        bad = np.abs(away - radius) > max(ROUND * radius, 0.5)
        first = int(np.flatnonzero(bad)[0]) if bad.any() else 0
        self.without(
            bad,
            f"this place lies {away[first]:.4g} mm from the centre, and radius_mm = {radius:g}",
            "look at centre, radius_mm and the unit of the places",
        )
        end = saturation.at_an_end(self.r.columns["radial_um"], self._place())
        self.without(
            end,
            "radial_um stands at the end of what the instrument can read",
            "a smaller error first, or a longer range",
        )

    def _follows(self) -> None:
        """Actual places follow the commanded ones."""
        for letter in (x for x in self.r.axes if x in XYZ):
            cmd, act = self.r.position(letter), self.r.columns[f"{letter}_act_mm"]
            spread = float(np.std(cmd))
            if spread < 0.05:
                continue
            # regression of actual on commanded: 1 of an axis that follows, 25.4 of one logged in
            # another unit
            slope = float(np.mean((cmd - cmd.mean()) * (act - act.mean()))) / spread**2
            apart = float(np.std(act - cmd)) / spread
            if apart > 0.5 or abs(slope - 1) > 0.2:
                unit = next(
                    (w for f, w in UNITS.items() if abs(slope / f - 1) < 0.05 and f != 1), ""
                )
                worst = int(np.argmax(np.abs((act - act.mean()) - (cmd - cmd.mean()))))
                raise RecordingError(
                    f"{letter}_act_mm moves {slope:.4g} mm for every mm of {letter}_cmd_mm, and"
                    " does not follow it",
                    (
                        f"the unit may be another: {unit}"
                        if unit
                        else (
                            "another axis' column, rows mixed up, or an encoder that was not"
                            " connected"
                        )
                    ),
                    self.at(worst),
                )
            still = saturation.while_moving(cmd, act)
            self.without(
                still,
                f"{letter}_act_mm does not change while {letter}_cmd_mm goes on",
                "the encoder, or the log, hangs",
            )

    def _alive(self) -> None:
        if _constant(self.r) and any(self.machine.tables.values()):
            name = _reading(self.r)
            raise RecordingError(
                f"{name} = {self.r.columns[name][0]:g} in all {len(self.r)} rows",
                "the instrument was not connected, or the column is another",
                self.at(0),
            )

    def _enough(self) -> Recording:
        n, least = len(self.r), self.least
        if n < least:
            raise RecordingError(
                f"{n} {'row' if n == 1 else 'rows'} can be used, and {least} at least tell an"
                " effect from noise",
                "record more, or leave this file out",
                Place(self.r.file, int(self.r.lines[0]) if n else 1),
            )
        return self.r
