"""Machines for the tests of the reference: folders written from tables, and the seed's grinder."""

import csv
from pathlib import Path

from .machine import Machine

SEED = Path(__file__).resolve().parents[2] / "proof" / "seed" / "tables"
NANOMETRE = 1e-6
SECOND_ORDER = 2e-5  # mm; half of 0.38 mrad squared at 170 mm is 12 nm
S = -382.352941  # µrad


def write_machine(
    folder,
    chain,
    tables,
    *,
    measured_at={},
    squareness={},
    tool={},
    control="linuxcnc",
    diameter=(),
    offsets={},
    travel=(-1000.0, 1000.0),
    outside="error",
):
    """A machine folder. tables: {axis: {"nodes": [...], column: [...]}}; returns the folder."""

    def inline(table):
        return "{ " + ", ".join(f"{key} = {float(value)!r}" for key, value in table.items()) + " }"

    folder.mkdir(parents=True, exist_ok=True)
    text = [
        f'format = "gcomp-machine/1"\nname = "m"\ncontrol = "{control}"\nchain = "{chain}"',
        f"diameter = {list(diameter)!r}".replace("'", '"'),
    ]
    for axis, table in tables.items():
        text.append(
            f"[axes.{axis}]\ntravel = {list(travel)}\nleast_increment = 0.0001\ntable ="
            f' "{axis}.csv"\nmeasured_at = {inline(measured_at.get(axis, {}))}'
        )
        columns = dict(table)
        rows = zip(columns.pop("nodes"), *columns.values())
        (folder / f"{axis}.csv").write_text(
            f"# written by a test\n{','.join([axis + '_mm', *columns])}\n"
            + "".join(",".join(repr(float(v)) for v in row) + "\n" for row in rows)
            + "# end\n"
        )
    text.append(
        "[squareness]\n"
        + "\n".join(f"{key} = {float(value)!r}" for key, value in squareness.items())
    )
    text.append("[tool]\n" + "\n".join(f"{key} = {float(value)!r}" for key, value in tool.items()))
    text.append(
        "[offsets]\n" + "\n".join(f"{key} = {inline(value)}" for key, value in offsets.items())
    )
    text.append(f'[limits]\noutside = "{outside}"')
    (folder / "machine.toml").write_text("\n".join(text) + "\n")
    return folder


def make(folder, *args, literal="stood", **settings):
    return Machine.load(write_machine(folder, *args, **settings), measured_at=literal)


def flat(axes, low=-500.0, high=500.0, **columns):
    """Tables of two nodes; columns: EXX_um=3.0 goes to axis X."""
    tables = {axis: {"nodes": [low, high]} for axis in axes}
    for name, value in columns.items():
        tables[name[2]][name] = [value, value]
    return tables


def seed_machine(folder, **settings):
    z = list(csv.DictReader(open(SEED / "table_6_1_studer_s36_z_axis.csv")))
    x = list(csv.DictReader(open(SEED / "table_6_2_studer_s36_x_axis.csv")))
    tables = {
        "Z": {"nodes": [float(r["z_mm"]) for r in z]},
        "X": {"nodes": [float(r["x_mm"]) for r in x]},
    }
    for ours, theirs in (("fwd", "forward"), ("rev", "reverse")):
        tables["Z"][f"EZZ_um_{ours}"] = [1000 * float(r[f"dzz_{theirs}_mm"]) for r in z]
        tables["Z"][f"EXZ_um_{ours}"] = [1000 * float(r[f"dxz_{theirs}_mm"]) for r in z]
        tables["Z"][f"EBZ_urad_{ours}"] = [1000 * float(r[f"eyz_{theirs}"]) for r in z]
        tables["X"][f"EXX_um_{ours}"] = [1000 * float(r[f"dxx_{theirs}_mm"]) for r in x]
        tables["X"][f"EZX_um_{ours}"] = [1000 * float(r[f"dzx_{theirs}_mm"]) for r in x]
    return make(
        folder,
        "w-b-Z-X-t",
        tables,
        squareness={"B0X": S},
        control="fanuc-lathe",
        diameter=["X"],
        **settings,
    )
