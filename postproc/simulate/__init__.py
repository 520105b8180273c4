"""The machine that never was: a program in time, where the tool really goes, and what instruments
would have read.

program.py reads the text, path.py lays the way, plan.py times it, history.py follows what each axis
has been through, actual.py adds tables and effects, instruments/ read them, experiments.py writes
the programs of tests.
"""

from __future__ import annotations
