"""How much more probable the readings are with each block of the dictionary than without it."""

from __future__ import annotations

import numpy as np

from postproc.diagnose.parts import surprise

TRIED = (0.3, 1.0, 10.0, 100.0)  # times the usual size of an effect


def factors(
    widths: np.ndarray, slab: np.ndarray, dy: np.ndarray, dd: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(B, R) twice the logarithm of the Bayes factor of blocks of widths (B,), each at the
    likeliest of the sizes TRIED; (K,) coefficients by the first of R readings and their standard
    deviations, at the largest size. slab (K,): usual standard deviations; dy (K, R): products of
    the columns, all else taken out, with readings; dd (P,): of the pairs of columns of one block,
    the upper triangle row by row.

    A block's precision in units of its slab has eigenvalues p: at t times the usual size each adds
    t^2 b^2 / (1 + t^2 p) - log(1 + t^2 p), b the product along its eigenvector (MacKay, Neural
    Computation 4, 1992, 415)."""
    result = np.full((len(widths), dy.shape[1]), -np.inf)
    coefficients, spread = np.zeros(len(dy)), np.zeros(len(dy))
    first = np.cumsum(widths) - widths
    start = np.cumsum(widths * (widths + 1) // 2) - widths * (widths + 1) // 2
    for w in np.unique(widths):
        which = np.flatnonzero(widths == w)
        i, j = np.triu_indices(w)
        m = np.zeros((len(which), w, w))
        entries = dd[start[which][:, None] + np.arange(len(i))]
        # dd holds upper triangles, block behind block; blocks of one width are worked out together.
        m[:, i, j], m[:, j, i] = entries, entries
        at = first[which][:, None] + np.arange(w)
        usual = slab[at]
        # Turned once, then every size of TRIED costs a few divisions: the prior is t^2 times the
        # unit matrix in these coordinates, whatever t.
        power, turned = np.linalg.eigh(m * usual[:, :, None] * usual[:, None, :])
        along = turned.transpose(0, 2, 1) @ (dy[at] * usual[:, :, None])
        for scale in TRIED:
            kept = 1.0 / (1.0 + scale**2 * np.maximum(power, 0.0))
            now = scale**2 * np.einsum("bwr,bw->br", along**2, kept)
            now += np.log(kept).sum(axis=1)[:, None] - surprise(scale, 1.0)
            result[which] = np.maximum(result[which], now)
        # kept and scale are those of the largest size: coefficients that the prior hardly draws to
        # zero
        mean = np.einsum("bvw,bw->bv", turned, kept * along[:, :, 0])
        coefficients[at] = scale**2 * mean * usual
        spread[at] = scale * np.sqrt(np.einsum("bvw,bw->bv", turned**2, kept)) * usual
    return result, coefficients, spread


def likeliest_size(within: np.ndarray, along: np.ndarray, slab: np.ndarray) -> float:
    """Of the sizes TRIED, from the usual one up, the likeliest of columns with products within
    (w, w) and along (w,), all else taken out."""
    power, turned = np.linalg.eigh(within * np.outer(slab, slab))
    square = (turned.T @ (along * slab)) ** 2

    def worth(scale: float) -> float:
        kept = 1.0 / (1.0 + scale**2 * np.maximum(power, 0.0))
        return float(np.sum(scale**2 * square * kept + np.log(kept)) - surprise(scale, 1.0))

    return max((scale for scale in TRIED if scale >= 1.0), key=worth)
