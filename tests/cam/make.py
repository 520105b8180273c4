"""Makes the programs of this folder by running PrusaSlicer and FreeCAD, as a person at the screen
would.

    apt-get install --no-install-recommends prusa-slicer freecad-python3
    python -m tests.cam.make [--only NAME]

PrusaSlicer slices a washer with the stock profiles that come with it (printer, its default print
and filament profile, with what they inherit); a few printers a second time with the extruder's
words the other way (absolute, relative). FreeCAD makes a plate with a contour, a pocket and four
holes (freecad_plate.py) and writes it with six of its post-processors. The output is kept as it was
written; README.md says of every file what it came from.
"""

from __future__ import annotations

import argparse
import math
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
PROFILES = Path("/usr/share/PrusaSlicer/profiles")
# The extruder's words the other way than in the profile; PrusaSlicer wants no G92 E0 with absolute
# ones, and one with relative.
ABSOLUTE = {"use_relative_e_distances": "0", "before_layer_gcode": "", "layer_gcode": ""}
RELATIVE = {"use_relative_e_distances": "1", "layer_gcode": "G92 E0"}
# File name: vendor's bundle, printer, what is set otherwise.
PRINTERS: dict[str, tuple[str, str, dict[str, str]]] = {
    "prusa-mk3s": ("PrusaResearch", "Original Prusa i3 MK3S & MK3S+", {}),
    "prusa-mk3s-absolute": ("PrusaResearch", "Original Prusa i3 MK3S & MK3S+", ABSOLUTE),
    "prusa-mk3s-mmu2": ("PrusaResearch", "Original Prusa i3 MK3S & MK3S+ MMU2S Single", {}),
    "prusa-mini": ("PrusaResearch", "Original Prusa MINI & MINI+", {}),
    "ender-3": ("Creality", "Creality Ender-3 (0.4 mm nozzle)", {}),
    "ender-3-absolute": ("Creality", "Creality Ender-3 (0.4 mm nozzle)", ABSOLUTE),
    "ender-3-bltouch": ("Creality", "Creality Ender-3 BLTouch (0.4 mm nozzle)", {}),
    "anycubic-i3-mega": ("Anycubic", "Anycubic i3 Mega", {}),
    "sidewinder-x1": ("Artillery", "Artillery Sidewinder X1", {"first_layer_height": "0.2"}),
    "neptune-2": ("Elegoo", "Elegoo Neptune-2", {}),
    "lulzbot-taz6": ("LulzBot", "Taz6 Aero 0.5mm", {"first_layer_height": "0.3"}),
    "ratrig-v-core-3": ("RatRig", "RatRig V-Core-3-300", {}),
    "voron-v2": ("Voron", "Voron_v2_250 0.4 nozzle", {}),
    "jubilee": ("Jubilee", "Jubilee", {}),
    "snapmaker-a350": ("Snapmaker", "Snapmaker A350", {}),
    "snapmaker-a350-relative": ("Snapmaker", "Snapmaker A350", RELATIVE),
    "zonestar-z5x": ("Zonestar", "Zonestar Z5X", {}),
    "deltiq-2": ("TriLAB", "DeltiQ 2 - 0.6 nozzle", {}),
    "infinity3d-dev-200": ("Infinity3D", "Infinity3D DEV-200", {}),
}
# File name: post-processor and its arguments. GRBL itself has no G81; grblHAL has.
POSTS = {
    "freecad-linuxcnc": ("linuxcnc", ""),
    "freecad-grbl": ("grbl", "--translate_drill"),
    "freecad-grblhal": ("grbl", ""),
    "freecad-mach3": ("mach3_mach4", ""),
    "freecad-centroid": ("centroid", ""),
    "freecad-marlin": ("marlin", ""),
    "freecad-smoothie": ("smoothie", ""),
}
NO_KEYS = (
    "inherits",
    "renamed_from",
    "compatible_printers",
    "compatible_printers_condition",
    "compatible_prints",
    "compatible_prints_condition",
    "default_print_profile",
    "default_filament_profile",
    "printer_notes",
)


def sections(path: Path) -> dict[str, dict[str, str]]:
    """The sections of a vendor's bundle by their whole name ("printer:NAME")."""
    found: dict[str, dict[str, str]] = {}
    for line in path.read_text("utf-8").splitlines():
        head = re.fullmatch(r"\[(.+)\]\s*", line)
        if head:
            found[head[1]] = {}
        elif "=" in line and not line.startswith("#") and found:
            key, value = line.split("=", 1)
            found[list(found)[-1]][key.strip()] = value.strip()
    return found


def flat(bundle: dict[str, dict[str, str]], kind: str, name: str) -> dict[str, str]:
    """A profile with all that it inherits; what it says itself, and what is named later, counts."""
    own = bundle[f"{kind}:{name}"]
    result: dict[str, str] = {}
    for parent in filter(None, (p.strip() for p in own.get("inherits", "").split(";"))):
        result |= flat(bundle, kind, parent)
    return result | own


def called(bundle: dict[str, dict[str, str]], kind: str, name: str) -> str:
    """The default profile of that name, of the first extruder; a bundle may leave the ending of the
    name out."""
    name = name.split(";")[0].strip('" ')
    if f"{kind}:{name}" in bundle:
        return name
    return next(key for key in bundle if key.startswith(f"{kind}:{name} ")).removeprefix(f"{kind}:")


def washer(outer: float = 4.0, inner: float = 2.0, height: float = 0.4, sides: int = 20) -> str:
    """An STL of a flat ring, mm."""
    turn = [2 * math.pi * k / sides for k in range(sides + 1)]
    out = [(outer * math.cos(a), outer * math.sin(a)) for a in turn]
    in_ = [(inner * math.cos(a), inner * math.sin(a)) for a in turn]
    facets = []
    for a, b, c, d in zip(in_, out, out[1:], in_[1:], strict=False):
        low = [(*p, 0.0) for p in (a, b, c, d)]
        high = [(*p, height) for p in (a, b, c, d)]
        for p, q, r, s in (
            (low[0], low[3], low[2], low[1]),
            high,
            (low[1], low[2], high[2], high[1]),
            (low[3], low[0], high[0], high[3]),
        ):
            facets += [(p, q, r), (p, r, s)]
    lines = ["solid washer"]
    for facet in facets:
        lines += [
            "facet normal 0 0 0",
            "outer loop",
            *(f"vertex {x:.6f} {y:.6f} {z:.6f}" for x, y, z in facet),
            "endloop",
            "endfacet",
        ]
    return "\n".join([*lines, "endsolid washer", ""])


def slice_(name: str, folder: Path) -> str:
    """Slice the washer with a stock printer; returns what was done."""
    vendor, printer, more = PRINTERS[name]
    bundle = sections(PROFILES / f"{vendor}.ini")
    of_printer = flat(bundle, "printer", printer)
    printed = called(bundle, "print", of_printer["default_print_profile"])
    of_print = flat(bundle, "print", printed)
    filament = called(bundle, "filament", of_printer["default_filament_profile"])
    config = of_print | flat(bundle, "filament", filament) | of_printer | more
    config = {key: value for key, value in config.items() if key not in NO_KEYS}
    (folder / "washer.stl").write_text(washer())
    (folder / "profile.ini").write_text(
        "".join(f"{key} = {value}\n" for key, value in config.items())
    )
    command = [
        "prusa-slicer",
        "--load",
        "profile.ini",
        "--export-gcode",
        "--output",
        "out.gcode",
        "washer.stl",
    ]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    made = folder / "out.gcode"
    if not made.exists():
        sys.exit(f"{name}: PrusaSlicer wrote nothing:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    (HERE / f"{name}.gcode").write_bytes(made.read_bytes())
    set_ = ", ".join(f"{key} = {value}" for key, value in more.items())
    version = made.read_text("latin-1").split(" on ")[0].removeprefix("; generated by ")
    return f"{version}, {vendor}: {printer}; {printed}; {filament}{'; ' * bool(set_)}{set_}"


def mill(folder: Path) -> dict[str, str]:
    """The plate with every post-processor; returns what was done, by file."""
    said = {}
    wanted = "\n".join(" ".join((name, *post)) for name, post in POSTS.items())
    environment = os.environ | {"CAM_OUT": str(folder), "CAM_POSTS": wanted, "HOME": str(folder)}
    command = ["freecadcmd", str(HERE / "freecad_plate.py")]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment)
    version = re.search(r"FREECAD (\S+)", done.stdout)
    for name, (post, arguments) in POSTS.items():
        made = folder / f"{name}.nc"
        if not made.exists() or version is None:
            sys.exit(f"{name}: FreeCAD wrote nothing:\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
        (HERE / made.name).write_bytes(made.read_bytes())
        said[made.name] = (
            f"FreeCAD {version[1]}, Path, {post}_post{' ' * bool(arguments)}{arguments}"
        )
    return said


def main() -> None:
    """Make all programs, or one, and print a line of the table in README.md for each."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", metavar="NAME")
    only = parser.parse_args().only
    said: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in PRINTERS:
            if only in (None, name):
                said[f"{name}.gcode"] = slice_(name, Path(folder))
                (Path(folder) / "out.gcode").unlink()
        if only in (None, "freecad"):
            said |= mill(Path(folder))
    for name, origin in sorted(said.items()):
        print(f"| {name} | {origin} |")


if __name__ == "__main__":
    main()
