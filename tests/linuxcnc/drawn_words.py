"""Numbers and lines of random programs: what all their kinds share."""

from __future__ import annotations

import random

TOOLS = {
    1: {"Z": 10.0, "D": 6.0},
    2: {"Z": 20.5, "X": 5.0, "D": 8.0},
    3: {"X": 1.0, "Y": -2.0, "Z": 3.25},
}
SYSTEMS = ("G54", "G55", "G56", "G59", "G59.1", "G59.3")
PLANES = {"G17": "XYZ", "G18": "ZXY", "G19": "YZX"}  # first, second, normal
CENTRE = {"X": "I", "Y": "J", "Z": "K"}
TRIPLES = ((3, 4, 5), (5, 12, 13), (8, 15, 17), (7, 24, 25), (20, 21, 29), (0, 1, 1))
ROTARY = "ABC"
LONGEST = 200  # of a line; LinuxCNC takes 252


def number(rng: random.Random, value: float) -> str:
    """One of the ways to write a number of at most four decimals."""
    text = f"{abs(value):.4f}".rstrip("0").rstrip(".") or "0"
    if text.startswith("0.") and rng.random() < 0.3:
        text = text[1:]
    elif "." not in text and rng.random() < 0.2:
        text += rng.choice((".", ".0"))
    elif rng.random() < 0.1:
        text = "0" + text
    negative = value < 0 and text.strip("0.")
    return ("-" if negative else "+" if rng.random() < 0.1 else "") + text


def line(rng: random.Random, *words: str) -> str:
    """The words, in any order, with some blanks and comments about them."""
    words = [word for word in words if word]
    rng.shuffle(words)
    text = rng.choice((" ", " ", " ", "", "  ")).join(words)
    if rng.random() < 0.1:
        text = text.lower()
    if rng.random() < 0.1:
        text += rng.choice((" (note)", " ; note"))
    return f"N{rng.randint(1, 999)} {text}" if rng.random() < 0.1 else text


def some(rng: random.Random, letters: str, least: int = 1) -> list[str]:
    return rng.sample(letters, rng.randint(least, len(letters)))
