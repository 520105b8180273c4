"""Random streams: every draw follows from seed, kind and number of a case and the purpose of the
draw."""

from __future__ import annotations

import hashlib

import numpy as np


def digest(*words: object) -> bytes:
    return hashlib.sha256("/".join(map(str, words)).encode()).digest()


def stream(*words: object) -> np.random.Generator:
    """A generator of its own for these words; another purpose is another stream, so that a draw
    more here moves nothing there."""
    return np.random.default_rng(np.frombuffer(digest(*words), np.uint32))


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
