"""Traces of very many samples: read in blocks, averaged to rows that are short where something
fades, named and sized as short ones are."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from postproc import recordings
from postproc.cli import main
from postproc.diagnose import averages, noise, rounding, spectra
from postproc.effects import State, waves_of
from postproc.recordings import _columns

ROOT = Path(__file__).resolve().parents[2]
STUDER = str(ROOT / "machines" / "studer-s36")
N = 2 * _columns.BLOCK + 321


def log(rows: list[str]) -> bytes:
    head = '# format = "gcomp-recording/1"\n# kind = "trace"\nrun,t_s,X_cmd_mm,X_act_mm,T_air_C\n'
    return (head + "\n".join(rows) + "\n").encode()


def read(data: bytes):
    return recordings.read(
        recordings.Source("a.csv", data), options=recordings.ReadingOptions(strict=False)
    )


def test_blocks_are_read_as_single_lines_are():
    """A row that can not be used, an empty cell, a comment and a blank line change what they
    should, and nothing else."""
    rng = np.random.default_rng(3)
    rows = [
        f"{1 + k // 9000},{k * 1e-3:.3f},{v:.4f},{v + 1e-3:.4f},20.5"
        for k, v in enumerate(rng.uniform(0, 100, N))
    ]
    plain = read(log(rows))
    assert len(plain) == N and not plain.faults
    assert plain.lines.tolist() == list(range(4, N + 4))
    assert plain.columns["X_cmd_mm"][[0, 20_001, -1]] == pytest.approx(
        [float(rows[k].split(",")[2]) for k in (0, 20_001, -1)]
    )
    hurt = list(rows)
    hurt[30_000] = hurt[30_000].replace(",20.5", ",")
    hurt[30_001] = "2,x,1,1,20.5"
    hurt[100] = "# a word"
    hurt[N - 2] = ""
    other = read(log(hurt))
    assert [f.line for f in other.faults] == [30_005]
    same = np.delete(np.arange(N), [100, 30_001, N - 2])
    assert other.lines.tolist() == (same + 4).tolist()
    for name, column in plain.columns.items():
        wanted = column[same]
        if name == "T_air_C":
            wanted = np.where(same == 30_000, np.nan, wanted)
        assert np.array_equal(other.columns[name], wanted, equal_nan=True)


def test_a_column_of_words_is_one_in_every_block():
    rows = [f"1,{k * 1e-3:.3f},1,1,{'warm' if k == N - 1 else 20}" for k in range(N)]
    data = log(rows).replace(b"T_air_C", b"remark")
    assert read(data).columns["remark"].tolist()[-2:] == ["20", "warm"]


def test_rows_after_a_turn_are_short_and_the_mean_stays():
    n = averages.LONG * 4
    t = np.arange(n) * 1e-3
    side = np.where((t // 25) % 2 == 0, 1.0, -1.0)
    y = np.sin(t)
    columns = {
        "y": y,
        "time": t,
        "run": np.ones(n),
        "line": np.arange(n),
        "X approach": side,
        "channel T_air_C": np.full(n, 20.0),
    }
    averaged = averages.averaged(columns)
    size = np.round(averaged["width"] / 1e-3).astype(int)
    width = int(np.ceil(n / averages.MOST_OF_LONG))
    assert size.sum() == n and len(size) < 1.5 * averages.MOST_OF_LONG
    assert np.sum(size * averaged["y"]) == pytest.approx(y.sum(), abs=1e-9)
    first = np.flatnonzero(np.diff(averaged["X approach"]) != 0) + 1
    assert len(first) == 7
    for k in first:
        assert size[k] == 1 and (np.diff(size[k : k + 8]) >= 0).all()
        after = np.cumsum(size[k : k + 30]) - size[k : k + 30]
        assert (size[k : k + 30] <= np.maximum(1, np.maximum(after // 4, 1))).all() or size[
            k : k + 30
        ].max() <= width
    assert set(averaged["channel T_air_C"]) == {20.0}


def test_places_kept_of_a_row_stand_in_the_middle_of_what_they_stand_for():
    n = 1_000_000
    x = np.arange(n) * 0.01
    columns = {
        "y": np.zeros(n),
        "time": np.arange(n) * 1e-3,
        "run": np.ones(n),
        "line": np.arange(n),
        "X position": x,
        "X approach": np.ones(n),
    }
    averaged = averages.averaged(columns)
    inside = averaged["inside"]["X"]
    assert len(inside) <= averages.MOST_INSIDE and (averaged["width"] > 0.098).all()
    # the mean of 100 samples, told by every fourth of them, is off by half a sample
    assert np.nanmean(inside, axis=0) == pytest.approx(averaged["X position"], abs=0.006)
    wave = np.add.reduceat(np.cos(2 * np.pi * x / 3.0), np.arange(0, n, 100)) / 100
    state = State({"X": averaged["X position"]}, {}, {}, inside={"X": inside})
    assert waves_of(state, "X", 1 / 3.0)[0] == pytest.approx(wave, abs=0.012)


def test_whitening_in_blocks_takes_out_what_the_samples_before_predict():
    """As the recurrence says it, over the ends of blocks; the first of a passage as they are."""
    n, ar = 9000, np.array([0.5, -0.2, 0.1])
    columns = np.random.default_rng(5).normal(size=(n, 9))
    unit = noise.Unit(
        np.arange(n), "tool", True, np.array([0, 4000, n]), np.arange(n) * 1.0, np.full(n, 2.0)
    )
    unit.ar, unit.innovation = ar, 0.25
    assert columns.nbytes > 2 * noise.CACHED
    wanted = columns / 2.0
    scaled = wanted.copy()
    for k in [*range(3, 4000), *range(4003, n)]:
        wanted[k] = (scaled[k] - ar @ scaled[k - 3 : k][::-1]) / 0.5
    assert unit.whitened(columns) == pytest.approx(wanted, abs=1e-12)
    assert unit.whitened(columns[:, 0]) == pytest.approx(wanted[:, 0], abs=1e-12)


def test_a_period_is_polished_alike_from_few_samples_and_from_very_many():
    frequency, found = 0.2137, []
    for n in (1500, 60_000):
        t = np.linspace(0.0, 300.0, n)
        wave = np.cos(2 * np.pi * frequency * t + 0.7)
        found.append(spectra.polished(0.2145, 0.7 / 300, [(t, wave, 1.0)]))
    assert len(spectra._turned(t, wave, 0.2145, 0.7 / 300)[0]) < 1500
    assert found[0] == pytest.approx(found[1], abs=1e-9)
    assert found[0] == pytest.approx(frequency, abs=0.02 / 300)


def test_a_value_that_stands_late_in_a_log_tells_its_rounding():
    place = np.round(np.linspace(10.0, 99.0, 5000), 1)
    assert np.all(rounding.step(place) == 0.1)
    place[4000] += 0.003
    assert np.all(rounding.step(place) == pytest.approx(0.001))


def test_single_samples_tell_the_noise_of_a_row():
    rng = np.random.default_rng(4)
    y = np.sin(np.arange(40_000) * 1e-3) + rng.normal(0, 3e-4, 40_000)
    assert averages._grain(y) == pytest.approx(3e-4, rel=0.03)


@pytest.mark.xfail(
    strict=True,
    reason=(
        "a spike of 12 um beside a lag of 100 um is below the error of form of the lag (a tenth)"
    ),
)
def test_names_and_sizes_do_not_depend_on_how_often_was_sampled(tmp_path):
    """The same motion at 100 and 1000 Hz: lag, lost motion and a spike that lasts 25 ms."""
    moves = [
        f"G1 X{60 + 20 * k} Z{80 + 9 * k} F{f}\nG1 X{200 - 9 * k} Z{140 + 5 * k}"
        for f in (1500, 4000)
        for k in range(5)
    ]
    (tmp_path / "p.nc").write_text("G0 X40 Z60\nG4 P0.5\n" + "\n".join(moves) + "\nG4 P0.5\nM2\n")
    effects = (
        "servo_lag:X:tau_ms=1.5",
        "backlash:Z:size_um=8,play_mm=0",
        "reversal_spike:X:size_um=12,slope_um=0,tau_ms=25",
    )
    found = {}
    for rate in (100, 1000):
        file, out = tmp_path / f"{rate}.csv", tmp_path / f"{rate}.json"
        more = [word for effect in effects for word in ("--with", effect)]
        assert (
            main(
                [
                    "simulate",
                    str(tmp_path / "p.nc"),
                    "--machine",
                    STUDER,
                    "--instrument",
                    "log",
                    "--set",
                    f"rate={rate}",
                    "--set",
                    "sees=tool",
                    "--parts",
                    "3",
                    "--noise",
                    "0.4",
                    "--seed",
                    "5",
                    "-o",
                    str(file),
                    "--quiet",
                    *more,
                ]
            )
            == 0
        )
        assert (
            main(["diagnose", str(file), "--machine", STUDER, "--json", str(out), "--quiet"]) == 0
        )
        told = json.loads(out.read_text())
        found[rate] = {
            e["effect"] + ":" + e["axis"]: e["parameters"]
            for e in told["effects"]
            if e["status"] == "accepted"
        }
        assert told["recordings"][0]["rows"] > (averages.LONG if rate == 1000 else 1000)
        # the same while an axis moves
        play = found[rate].keys() & {"backlash:Z", "coulomb_friction:Z"}
        assert {"servo_lag:X", "reversal_spike:X"} <= set(found[rate]) and len(play) == 1
    assert found[1000]["servo_lag:X"]["tau_ms"]["value"] == pytest.approx(1.5, rel=0.02)
    assert found[1000][play.pop()]["size_um"]["value"] == pytest.approx(8.0, rel=0.05)
    assert found[1000]["reversal_spike:X"]["size_um"]["value"] == pytest.approx(12.0, rel=0.15)
    assert found[100]["servo_lag:X"]["tau_ms"]["value"] == pytest.approx(
        found[1000]["servo_lag:X"]["tau_ms"]["value"], rel=0.02
    )
