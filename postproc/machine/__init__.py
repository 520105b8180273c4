"""PHYSICS: axes, who carries whom, measured errors. Knows no program text."""
