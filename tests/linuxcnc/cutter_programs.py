"""Forty programs with G41 and G42 that LinuxCNC accepts, as text with a tool table: the made ones
and those of programs/.

Every contour is a list of blocks in the plane; the tools have diameters from 0.8 to 20 mm.
"""

from __future__ import annotations

import math

from tests.linuxcnc import oracle

TOOLS = {
    1: {"Z": 10.0, "D": 6.0},
    2: {"D": 3.0},
    4: {"D": 10.0},
    5: {"D": 20.0},
    6: {"D": 0.8, "Q": 2, "I": 95.0, "J": 155.0},
    7: {"D": 1.6, "Q": 3, "I": 85.0, "J": 25.0},
}
PARAMETERS = {5223: -250.0}  # G54 of the mills: Z in the middle of its travel
EXPANDED = ("cutter_o_words", "cutter_rotated")  # written out first: other tests
HEAD = ("G21 G90 G17 G54", "G0 Z20")


def rectangle(width: float, height: float) -> list[str]:
    """Counter-clockwise from its lower left corner, one plane word a block."""
    return [f"X{width:g}", f"Y{height:g}", "X0", "Y0"]


def rounded(width: float, height: float, radius: float) -> list[str]:
    """Counter-clockwise, corners of a radius, from the middle of the lower side."""
    w, h, r = width / 2, height / 2, radius
    return [
        f"G1 X{w - r:g}",
        f"G3 X{w:g} Y{-h + r:g} J{r:g}",
        f"G1 Y{h - r:g}",
        f"G3 X{w - r:g} Y{h:g} I{-r:g}",
        f"G1 X{-w + r:g}",
        f"G3 X{-w:g} Y{h - r:g} J{-r:g}",
        f"G1 Y{-h + r:g}",
        f"G3 X{-w + r:g} Y{-h:g} I{r:g}",
        "G1 X0",
    ]


def star(points: int, outer: float, inner: float) -> list[str]:
    """Sharp outer and obtuse inner corners, counter-clockwise."""
    lines = []
    for k in range(1, 2 * points + 1):
        angle, radius = math.pi * k / points, inner if k % 2 else outer
        lines.append(f"X{radius * math.cos(angle):.4f} Y{radius * math.sin(angle):.4f}")
    return lines


def polygon(count: int, radius: float) -> list[str]:
    """Short straight blocks around a circle, counter-clockwise from its right end."""
    turns = [2 * math.pi * k / count for k in range(1, count + 1)]
    return [f"X{radius * math.cos(t):.4f} Y{radius * math.sin(t):.4f}" for t in turns]


def outside(
    contour: list[str], tool: int, x: float = 0.0, y: float = 0.0, side: str = "G42"
) -> list[str]:
    """Down beside the contour, straight in, around, straight out."""
    return [
        f"G0 X{x - 30:g} Y{y - 25:g}",
        "G1 Z-2 F500",
        f"{side} D{tool} G1 X{x - 15:g} Y{y:g} F800",
        f"X{x:g}",
        *contour,
        f"Y{y - 20:g}",
        f"G40 X{x - 30:g} Y{y - 25:g}",
    ]


def pocket(tool: int, width: float, height: float, radius: float, lead: float) -> list[str]:
    """Within rounded corners, in and out by a quarter of a circle."""
    h = height / 2
    return [
        "G0 X0 Y0",
        "G1 Z-3 F300",
        f"G41 D{tool} G1 X{-lead:g} Y{-h + lead:g} F700",
        f"G3 X0 Y{-h:g} I{lead:g}",
        *rounded(width, height, radius),
        f"G3 X{lead:g} Y{-h + lead:g} J{lead:g}",
        "G40 G1 X0 Y0",
    ]


def made() -> dict[str, tuple[str, dict]]:
    """Name to (text, tools) of what is written here."""
    steps = ["G1 Z-4 F200", "X80 F600", "Z-8", "Y50", "Z-2 X0", "Z-12", "Y0"]
    programs = {
        "rectangle_outside": outside(rectangle(120, 80), 4),
        "rectangle_outside_large_tool": outside(rectangle(120, 80), 5),
        "rectangle_inside": [
            "G0 X60 Y40",
            "G1 Z-2 F300",
            "G41 D4 G1 X60 Y0 F600",
            *rectangle(120, 80),
            "X70",
            "G40 Y40",
        ],
        "pocket_tangent": pocket(4, 90, 60, 8, 12),
        "pocket_corner_as_the_tool": pocket(4, 90, 60, 5.001, 12),
        "pocket_small_tool": pocket(2, 40, 30, 2, 4),
        "pocket_large": pocket(5, 200, 150, 10.5, 30),
        "star_outside": [
            "G0 X70 Y-40",
            "G1 Z-1 F300",
            "G42 D4 G1 X60 Y-20 F500",
            "X60 Y0",
            *star(6, 60, 35),
            "Y30",
            "G40 X90",
        ],
        "polygon_outside": [
            "G0 X60 Y-40",
            "G1 Z-1 F300",
            "G42 D4 G1 X40 Y-20 F500",
            "Y0",
            *polygon(90, 40),
            "Y15",
            "G40 X60",
        ],
        "polygon_inside": [
            "G0 X10 Y-20",
            "G1 Z-1 F300",
            "G41 D4 G1 X40 Y-15 F500",
            "Y0",
            *polygon(60, 40),
            "G40 X10 Y10",
        ],
        "z_steps": [
            "G0 X-30 Y-30",
            "G1 Z-2 F300",
            "G42 D4 G1 X-15 Y0 F700",
            "X0",
            *steps,
            "Y-20",
            "G40 X-30",
        ],
        "z_steps_far_down": [
            "G0 X-30 Y-30",
            "G1 Z-2 F300",
            "G42 D1 G1 X-15 Y0 F700",
            "X0",
            "X50",
            "Z-120",
            "Y60",
            "Z-20",
            "X0",
            "Z-140",
            "Y0",
            "Y-20",
            "G40 X-30",
        ],
        "helix_outside": [
            "G0 X60 Y-40",
            "G1 Z1 F300",
            "G42 D4 G1 X40 Y-20 F500",
            "Y0",
            *[f"G3 X40 Y0 I-40 Z{-2 * k}" for k in range(4)],
            "G1 Y15",
            "G40 X60",
        ],
        "helix_inside": [
            "G0 X0 Y0",
            "G1 Z1 F300",
            "G41 D4 G1 X20 Y-10 F500",
            "G3 X30 Y0 J10",
            *[f"G3 I-30 Z{-2 * k}" for k in range(4)],
            "G3 X20 Y10 I-10",
            "G40 G1 X0 Y0",
        ],
        "circle_inside": [
            "G0 X0 Y0",
            "G1 Z-1 F300",
            "G41 D1 G1 X15 Y-5 F500",
            "G3 X20 Y0 J5",
            "G3 I-20",
            "G3 X15 Y5 I-5",
            "G40 G1 X0 Y0",
        ],
        "circle_outside_large": [
            "G0 X130 Y-40",
            "G1 Z-1 F300",
            "G42 D5 G1 X100 Y-30 F500",
            "Y0",
            "G3 I-100",
            "G1 Y30",
            "G40 X130",
        ],
        "slot_arcs": [
            "G0 X0 Y0",
            "G1 Z-1 F300",
            "G41 D4 G1 X0 Y-8 F500",
            "X60",
            "G3 Y8 J8",
            "G1 X-60",
            "G3 Y-8 J-8",
            "G1 X5",
            "G40 Y0",
        ],
        "long_sides": (
            outside(rectangle(300, 150), 4, -150, -70)[:3]
            + ["X-150 Y-70", "X150", "Y80", "X-150", "Y-70", "Y-95", "G40 X-180"]
        ),
        "dynamic_mm": [
            "G0 X-30 Y-25",
            "G1 Z-2 F500",
            "G42.1 D12 G1 X-15 Y0 F800",
            "X0",
            *rectangle(90, 60),
            "Y-20",
            "G40 X-30",
        ],
        "lathe_nose": [
            "G18",
            "G0 X60 Z5",
            "G42 D6 G1 X20 Z2 F200",
            "Z-10",
            "X30 Z-25",
            "G2 X35 Z-30 I5",
            "G1 Z-60",
            "X60",
            "G40 X80 Z5",
        ],
        "lathe_bore": [
            "G18",
            "G0 X10 Z5",
            "G41 D7 G1 X40 Z3 F200",
            "Z-20",
            "X35 Z-30",
            "Z-50",
            "X20",
            "G40 X5 Z-40",
        ],
    }
    return {
        name: ("\n".join([*HEAD, *lines, "G0 Z20", "M2", ""]), TOOLS)
        for name, lines in programs.items()
    }


def stored() -> dict[str, tuple[str, dict]]:
    """The accepted cutter programs of programs/, with their tools."""
    found = {}
    for path in sorted(oracle.PROGRAMS.glob("cutter_*.ngc")):
        if path.stem not in EXPANDED:
            text, keywords = oracle.load(path)
            # from where it stands, so that the way in is corrected too
            text = text.replace("\n", "\nG0 X0 Y0 Z0\n", 1)
            found[path.stem] = (text, keywords.get("tools", {}))
    return found


def refused() -> dict[str, tuple[str, dict]]:
    """Cutter programs that LinuxCNC refuses."""
    found = {}
    for path in sorted(oracle.REFUSED.glob("cutter_*.ngc")):
        text, keywords = oracle.load(path)
        found[path.stem] = (text, keywords.get("tools", {}))
    return found
