"""Noise whose slow part is no effect: neither does a fit of it hide what it took, nor does noise of
all times get a name."""

from __future__ import annotations

import numpy as np
import pytest

from postproc.diagnose import noise
from tests.diagnose.test_workshop import HEAD, diagnosed, names


def test_what_a_smooth_fit_takes_out_of_white_noise_counts_as_noise():
    """A fit of 300 smooth columns B leaves (1 - P) y of white noise, P = B (B'B)^-1 B': its
    autocovariance and that of P y, sigma^2 P by expectation, are together that of white noise."""
    rng, n, sigma = np.random.default_rng(3), 1200, 2e-3
    y = sigma * rng.normal(size=n)
    b = noise.hats(np.arange(n, dtype=float), np.linspace(0.0, n - 1.0, 300))
    left = y - b @ np.linalg.lstsq(b, y, rcond=None)[0]
    posterior = sigma * np.linalg.qr(b)[0]
    alone, _, _ = noise.autoregression([left])
    ar, innovation, total = noise.autoregression([left], [posterior])
    assert alone.sum() < -0.2  # the slow power is gone
    assert len(ar) == 0 and innovation == 1.0
    assert total == pytest.approx(sigma, rel=0.05)


def one_over_f(seed: int, um: float, lines: int) -> str:
    """A log of curves of X and Y, 45 s: two sums of oscillations whose power falls with the
    frequency (flicker noise), and white noise of 0.1 um. No machine is behind them."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 45, 0.02)
    x, y = 300 + 120 * np.sin(2 * np.pi * t / 15), 200 + 80 * np.sin(2 * np.pi * t / 9)
    k = np.arange(1, lines + 1)

    def drawn() -> np.ndarray:
        size = np.sqrt(2 / k / np.sum(1 / k))
        phase = rng.uniform(0, 2 * np.pi, lines)
        waves = np.cos(np.outer(2 * np.pi * k / 99.0, t) + phase[:, None])
        slow: np.ndarray = um * (size * np.abs(rng.normal(size=lines))) @ waves
        return slow + 0.1 * rng.normal(size=len(t))

    dx, dy = drawn(), drawn()
    rows = [
        f"1,{a:.2f},{b:.5f},{c:.5f},{b + d * 1e-3:.6f},{c + e * 1e-3:.6f}"
        for a, b, c, d, e in zip(t, x, y, dx, dy, strict=True)
    ]
    head = HEAD.format("trace", "grid encoder") + '# sees = "tool"\n'
    return head + "run,t_s,X_cmd_mm,Y_cmd_mm,X_act_mm,Y_act_mm\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize(("seed", "um", "lines"), [(3, 1.0, 60), (0, 2.0, 120)])
def test_flicker_noise_alone_has_no_name(tmp_path, seed, um, lines):
    """Named abbe and sag, and cyclic, where nothing stood between the slow wander and the
    autoregression of a few samples."""
    assert names(diagnosed(tmp_path / "a", one_over_f(seed, um, lines))) == {}
