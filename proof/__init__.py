"""Proof that a concealed effect is found: cases made without the tool's own equations, and how its
answers are judged."""

import os

os.environ.setdefault(
    "OPENBLAS_NUM_THREADS", "1"
)  # before numpy is loaded: a process for each core, and not threads besides
