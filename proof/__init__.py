"""Proof that a concealed effect is found: cases made without the tool's own equations, and how its answers are judged."""
