"""Files that can not be used: name, file's name, bytes, options, the sentence that says why, and the line it names."""

from __future__ import annotations

import numpy as np

from tests.recordings import samples

TABLE = samples.readings(4)
RTL = samples.renishaw(TABLE)
SHEET = samples.interleaved(TABLE, sign=";", comma=False)
LASER = samples.laser_table(TABLE)
LONG = samples.canonical({"EZZ": (TABLE, "um")})
RTX = samples.dynamic(np.linspace(0, 1, 50))
COMP = samples.compensation(np.array([0.0, 50.0, 100.0]), np.zeros(3), np.full(3, 0.002), 0)
HEAD = '# format = "gcomp-recording/1"\n# kind = "targets"\n# quantity = "displacement"\n# sensitive = { Z = 1.0 }\n'
OWN = HEAD + "run,t_s,Z_mm,approach_Z,reading_um\n1,0,0.0,1,0.7\n1,1,10.0,1,1.7\n"
BALL = (
    '# format = "gcomp-recording/1"\n# kind = "ballbar"\n# centre = { X = 0.0, Y = 0.0 }\n# radius_mm = 100.0\n'
    "run,t_s,X_cmd_mm,Y_cmd_mm,radial_um,sense\n1,0,100.0,0.0,1.5,1\n"
)
DYNAMIC = {"axis": "X", "unit": "mm", "extra": {"command": "still"}}
TYPE0 = {"axis": "Z", "unit": "mm", "extra": {"type": "0"}}
MAP = {"columns": {"Z_mm": "pos", "run": "run", "reading_um": "dev"}}
CSV = "pos;run;dev\n0;1;1.5\n10;1;2.5\n"


def line_of(text: str, piece: str) -> int:
    """Where a piece of a sample stands: tests name lines by what is in them."""
    return text[: text.index(piece)].count("\n") + 1


def swap(text: str, old: str, new: str) -> str:
    assert text.count(old) >= 1, old
    return text.replace(old, new, 1)


def cut(text: str, piece: str) -> str:
    return text[: text.index(piece)]


ROW = f"2   5      {TABLE[1, 4]:.2f}"
CASES: list[tuple[str, str, str | bytes, dict, str, int]] = [
    # gcomp's own
    ("own: nothing at all", "a.csv", b"", {}, "the file is empty", 1),
    ("own: blank lines", "a.csv", b"\n\n  \n", {}, "the file is empty", 1),
    ("own: not UTF-8", "a.csv", OWN.encode() + b"1,2,\xff,1,1\n", {}, "byte 255 is not UTF-8 text", 8),
    ("own: TOML without quotes", "a.csv", swap(OWN, '"targets"', "targets"), {}, "the head is not valid TOML", 2),
    ("own: another version", "a.csv", swap(OWN, "recording/1", "recording/9"), {}, "format = 'gcomp-recording/9', and not 'gcomp-recording/1'", 1),
    ("own: unknown kind", "a.csv", swap(OWN, '"targets"', '"circles"'), {}, "kind = 'circles', and there is no such kind", 2),
    ("own: unknown quantity", "a.csv", swap(OWN, "displacement", "speed"), {}, "quantity = 'speed', and there is no such", 3),
    ("own: no sensitive vector", "a.csv", swap(OWN, "# sensitive = { Z = 1.0 }\n", ""), {}, "the head does not say sensitive: a vector is wanted", 1),
    ("own: no unit vector", "a.csv", swap(OWN, "Z = 1.0", "Z = 1.0, X = 1.0"), {}, "sensitive has the length 1.4142", 4),
    ("own: u is zero", "a.csv", swap(OWN, "# sens", "# u_um = 0.0\n# sens"), {}, "u_um = 0.0 is not above zero", 4),
    ("own: head alone", "a.csv", HEAD, {}, "there is no header row", 4),
    ("own: no rows", "a.csv", cut(OWN, "1,0,0.0"), {}, "there are no rows", 5),
    ("own: no position", "a.csv", swap(OWN, "Z_mm", "Z"), {}, "no column X_mm, Y_mm or Z_mm", 5),
    ("own: no reading", "a.csv", swap(OWN, "reading_um", "reading"), {}, "the column reading_um is missing", 5),
    ("own: a column twice", "a.csv", swap(OWN, "t_s", "run"), {}, "the column 'run' stands twice", 5),
    ("own: a column without a name", "a.csv", swap(OWN, "t_s", ""), {}, "a column has no name", 5),
    ("own: an empty reading", "a.csv", swap(OWN, "1,0.7", "1,"), {}, "reading_um is empty", 6),
    ("own: words for a reading", "a.csv", swap(OWN, "0.7", "none"), {}, "reading_um = 'none' is not a number", 6),
    ("own: not a number", "a.csv", swap(OWN, "0.7", "nan"), {}, "reading_um = 'nan' is not a number", 6),
    ("own: infinite", "a.csv", swap(OWN, "10.0", "inf"), {}, "Z_mm = 'inf' is not a number", 7),
    ("own: a cell too many", "a.csv", swap(OWN, "0.7", "0.7,3"), {}, "6 values under 5 columns", 6),
    ("own: an approach of 3", "a.csv", swap(OWN, "1,1.7", "3,1.7"), {}, "approach_Z = 3", 7),
    ("own: circle of no radius", "a.csv", swap(BALL, "100.0\n", "-1.0\n"), {}, "radius_mm = -1.0: a length above zero is wanted", 4),
    ("own: centre of another axis", "a.csv", swap(BALL, "Y = 0.0", "Z = 0.0"), {}, "centre names Z, which is not recorded", 5),
    ("own: sense 0", "a.csv", swap(BALL, "1.5,1", "1.5,0"), {}, "sense = 0", 6),
    # Renishaw's text
    ("rtl: cut in the targets", "z.rtl", cut(RTL, "300.0000"), {}, "there is no section DEVIATIONS::", line_of(RTL, "250.0000")),
    ("rtl: cut before the rows", "z.rtl", cut(RTL, "1   1  "), {}, "there are no deviations", line_of(RTL, "DEVIATIONS")),
    ("rtl: a target that is no number", "z.rtl", swap(RTL, "150.0000", "15O.0000"), {}, "the target '15O.0000' is not a number", line_of(RTL, "150.0000")),
    ("rtl: count and targets differ", "z.rtl", swap(RTL, "Target-count: 10", "Target-count: 11"), {}, "Target-count is 11, and 10 targets stand below it", line_of(RTL, "Target-count")),
    ("rtl: count of runs is a word", "z.rtl", swap(RTL, "Run-count: 4", "Run-count: four"), {}, "Run-count is 'four': that is not a whole number", line_of(RTL, "Run-count")),
    ("rtl: a run too many", "z.rtl", swap(RTL, "Run-count: 4", "Run-count: 3"), {}, "run 4, and the runs are 1 to 3", line_of(RTL, "4   10  ")),
    ("rtl: target number 11", "z.rtl", swap(RTL, ROW, ROW.replace("   5", "   11")), {}, "target number 11, and the targets are 1 to 10", line_of(RTL, ROW)),
    ("rtl: target number 0", "z.rtl", swap(RTL, ROW, ROW.replace("   5", "   0")), {}, "target number 0", line_of(RTL, ROW)),
    ("rtl: a reading twice", "z.rtl", swap(RTL, ROW, ROW.replace("   5", "   6")), {}, "run 2 has target 6 twice", line_of(RTL, ROW)),
    ("rtl: two columns", "z.rtl", swap(RTL, ROW, "2 5"), {}, "'2 5' is not a run, a target's number and a deviation", line_of(RTL, ROW)),
    ("rtl: commas and points", "z.rtl", swap(RTL, ROW, "2 5 1,55"), {}, "decimal commas and points are mixed: 1,55", line_of(RTL, ROW)),
    ("rtl: no axis", "z.rtl", swap(RTL, "Axis: Z", "Axis:"), {}, "does not say which axis moved", line_of(RTL, "USER-TEXT")),
    ("rtl: two axes", "z.rtl", swap(RTL, "Axis: Z", "Axis: X/Y"), {}, "does not say which axis moved", line_of(RTL, "USER-TEXT")),
    ("rta: pitch, yaw or roll", "z.rta", RTL, {}, "about which axis the rotation of Z was measured", line_of(RTL, "USER-TEXT")),
    ("rts: no unit", "z.rts", RTL, {"component": "EXZ"}, "does not say in which unit its readings are", line_of(RTL, "DEVIATIONS")),
    ("rtl: a reading of a megametre", "z.rtl", swap(RTL, ROW, "2 5 1e15"), {}, "the reading is 1e+15 um: no machine has that", line_of(RTL, ROW)),
    # Renishaw's dynamic records
    ("rtx: an odd byte", "x.rtx", RTX.replace(b"EOF::", b"\x00EOF::"), DYNAMIC, "401 bytes, which is no whole number of samples", 18),
    ("rtx: no samples", "x.rtx", samples.dynamic(np.zeros(0)), DYNAMIC, "there are 0 samples", 18),
    ("rtx: no rate", "x.rtx", RTX.replace(b"ample rate", b"ample time"), DYNAMIC, "does not say the Actual sample rate", 1),
    ("rtx: a rate of zero", "x.rtx", RTX.replace(b"Actual sample rate: 1000.0", b"Actual sample rate: 0"), DYNAMIC, "actual sample rate is '0'", 10),
    ("rtx: samples that are no numbers", "x.rtx", samples.dynamic(np.array([0.0, np.nan, 1.0])), DYNAMIC, "sample 2 is nan mm: no axis is there", 18),
    ("rtx: without Data:", "x.rtx", RTX.replace(b"Data:\r\n", b""), {"format": "renishaw-dynamic", **DYNAMIC}, "there is no line Data: in the header", 1),
    # sheets
    ("sheet: a word for a reading", "s.csv", swap(SHEET, f";{TABLE[1, 3]:.2f};", ";oops;"), {}, "'oops' under 'Down 1 (µm)' is not a number", 8),
    ("sheet: two units", "s.csv", swap(SHEET, "Down 1 (µm)", "Down 1 (mm)"), {}, "the readings are in um and in mm", 4),
    ("sheet: one column without direction", "s.csv", swap(SHEET, "Down 1", "Turn 1"), {"layout": "interleaved"}, "the heading 'Turn 1 (µm)' names no direction", 4),
    ("sheet: no unit", "s.csv", SHEET.replace(" (µm)", ""), {}, "does not say in which unit its readings are", 4),
    ("sheet: no axis", "s.csv", swap(SHEET, "Axis;Z", "Axes;Z"), {}, "does not say which axis moved", 4),
    ("sheet: an odd number of columns", "s.csv", "Target;1;2;3\n0;1;2;3\n1;2;3;4\n", {"layout": "blocks", "axis": "X", "unit": "um"}, "3 columns of readings are no pairs", 1),
    ("sheet: no numbers", "s.csv", "Target;Up;Down\na;b;c\n", {"layout": "blocks", "axis": "X"}, "there is no row of numbers", 1),
    ("sheet: a target twice", "s.csv", swap(SHEET, "\n50.0;", "\n0.0;"), {}, "run 1 has the target 0 twice: here and in line 5", 6),
    ("sheet: no table", "s.csv", "Target\n1\n2\n", {"layout": "blocks"}, "this is no table", 1),
    ("sheet: a strange decimal sign", "s.csv", SHEET + '1;"2;3\n', {"format": "iso-spreadsheet", "extra": {"decimal": "x"}}, "--set decimal=x is no decimal sign", 0),
    ("long sheet: run 1.5", "s.csv", "Target,Run,Dir,Deviation (um)\n0,1,+,1\n1,1.5,+,1\n", {"axis": "X"}, "run 1.5 is not a whole number from 1 on", 3),
    ("long sheet: a strange direction", "s.csv", "Target,Run,Dir,Deviation (um)\n0,1,north,1\n", {"axis": "X"}, "'north' is no direction", 2),
    # laser tables
    ("laser: a word for a target", "z.txt", swap(LASER, "\n100\t", "\n1oo\t"), {}, "the target '1oo' is not a number", line_of(LASER, "\n100\t") + 1),
    ("laser: a word for a reading", "z.txt", swap(LASER, f"\t{TABLE[0, 3]:.2f}\t", "\t*****\t"), {}, "'*****' under 'RUN 1 (µm)' is not a number", line_of(LASER, "\n150\t") + 1),
    ("laser: no runs", "z.txt", LASER.replace("RUN 1 ", "Pass 1 ").replace("RUN", "RUN x"), {"format": "laser-table"}, "there is no column RUN 1", 7),
    ("laser: a run twice", "z.txt", swap(LASER, "RUN 2", "RUN 1"), {}, "RUN 1 heads two columns", 7),
    ("laser: no rows", "z.txt", cut(LASER, "\n0\t") + "\n", {}, "there are no rows below Target Position", 7),
    ("laser: a record over time", "z.txt", "Comments: [drift]\nTime\tPosition\n0\t1\n1\t2\nEnvironmental Data:\n", {}, "a record over time, not of targets", 2),
    ("laser: no unit", "z.txt", LASER.replace(" (µm)", ""), {}, "does not say in which unit its readings are", 7),
    # the long table
    ("long: an unknown component", "a.csv", swap(LONG, "EZZ,Z", "QZZ,Z"), {}, "'QZZ' is no component", 2),
    ("long: another axis", "a.csv", swap(LONG, "EZZ,Z", "EZZ,X"), {}, "axis is 'X', and EZZ belongs to Z", 2),
    ("long: an angle in um", "a.csv", LONG.replace("EZZ", "EBZ"), {}, "EBZ is an angle, and its unit here is um", 2),
    ("long: an unknown unit", "a.csv", swap(LONG, ",um,", ",furlong,"), {}, "'furlong' is no unit of readings", 2),
    ("long: two units", "a.csv", swap(LONG, ",um,", ",mm,"), {}, "EZZ is in mm and in um", 3),
    ("long: a strange direction", "a.csv", swap(LONG, ",+,", ",north,"), {}, "dir 'north' is no direction", 2),
    ("long: no value", "a.csv", swap(LONG, f"{TABLE[0, 0]:.2f},um", ",um"), {}, "value is empty", 2),
    ("long: the axis elsewhere", "a.csv", swap(LONG, "10,20,50,", "10,20,51,"), {}, "z is 51, and the target of Z is 50", 3),
    ("long: a cell too few", "a.csv", swap(LONG, "20.5,20.1,0", "20.5,20.1"), {}, "12 cells under 13 columns", 2),
    ("long: a time that is none", "a.csv", swap(LONG, "20.1,7\n", "20.1,noon\n"), {}, "the time 'noon' is neither seconds nor a date", 3),
    ("long: a column is gone", "a.csv", swap(LONG, "dir,", ""), {"format": "canonical-long"}, "the column dir is missing", 1),
    # LinuxCNC
    ("comp: a heading", "Z.comp", "# nominal forward reverse\n" + COMP, {"format": "linuxcnc-compensation", **TYPE0}, "no three numbers: LinuxCNC stops reading here, and 3 lines below", 1),
    ("comp: a blank line", "Z.comp", swap(COMP, "\n", "\n\n"), TYPE0, "no three numbers", 2),
    ("comp: not ascending", "Z.comp", swap(COMP, "100.0000 ", "40.0000 "), TYPE0, "nominal 40 comes after 50", 3),
    ("comp: too many", "Z.comp", "".join(f"{i} {i} {i}\n" for i in range(257)), TYPE0, "entry 257: LinuxCNC holds 256", 257),
    ("comp: the other type", "Z.comp", COMP, {**TYPE0, "extra": {"type": "1"}}, "a deviation of -50 mm is no screw's", 2),
    # mapped
    ("map: a reading that is none", "a.csv", swap(CSV, "2.5", "x"), MAP, "reading_um 'x' is not a number", 3),
    ("map: a run of zero", "a.csv", swap(CSV, "10;1", "10;0"), MAP, "run 0 is not a whole number from 1 on", 3),
    ("map: no such column", "a.csv", swap(CSV, "dev", "d"), MAP, "no column is called 'dev'", 1),
    ("map: two such columns", "a.csv", swap(CSV, "run", "dev"), {"columns": {"Z_mm": "pos", "reading_um": "dev"}}, "2 columns are called 'dev'", 1),
    ("map: only headings", "a.csv", "pos;run;dev\n", MAP, "there are no readings", 1),
    ("map: a target twice", "a.csv", swap(CSV, "10;1", "0;1"), MAP, "run 1 has the target 0 twice", 3),
    ("map: far away", "a.csv", swap(CSV, "10;1", "1e9;1"), MAP, "the target is 1e+09 mm: no machine has that", 3),
    # nobody's
    ("a picture", "a.png", b"\x89PNG\r\n\x1a\n" + bytes(range(256)), {}, "this looks like no recording that gcomp knows", 1),
    ("a program", "a.nc", "G0 X0\nG1 X10 F100\nM30\n", {}, "this looks like no recording that gcomp knows", 1),
]  # fmt: skip
