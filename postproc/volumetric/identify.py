"""What the readings can not tell: directions in which the unknowns may move and no reading changes
by more than its noise.

In units of the prior the covariance has eigenvalues from 0 (told) to 1 (not told at all). What
belongs to those near 1 is a subspace; errors that it ties together can not be parted, whatever
their sum is.
"""

from __future__ import annotations

import itertools

import numpy as np

from postproc.volumetric.solve import Fit

# of the prior's variance: what is known to a third of what a machine may have is not measured
UNDETERMINED = 0.1
TIED = 0.05  # of a direction


def undetermined(fit: Fit) -> list[list[str]]:
    """Names of errors that can not be parted, in sets; a set of one can not be told at all, at some
    of its nodes at least."""
    prior = fit.unknowns.prior
    scaled = fit.covariance / np.outer(prior, prior)
    # without the widening by chi: how well the readings lie is asked here, not how much they
    # scatter
    values, vectors = np.linalg.eigh(scaled / fit.factor)
    open_ = vectors[:, values > UNDETERMINED]
    if not open_.shape[1]:
        return []
    # The projection on the open directions: its block [a, b] is not zero where errors a and b move
    # together in one of them, which is what can not be parted.
    onto = open_ @ open_.T
    names = [g.name for g in fit.unknowns.groups]
    n = len(names)
    share = np.zeros((n, n))
    for (i, a), (k, b) in itertools.product(enumerate(fit.unknowns.slices), repeat=2):
        share[i, k] = np.linalg.norm(onto[a, b])
    sets: list[set[int]] = []
    for i in np.flatnonzero(share.diagonal() > TIED).tolist():
        # a ties to b and b to c: one set of three, though a and c may share no direction of their
        # own
        tied = {i, *np.flatnonzero(share[i] > TIED).tolist()}
        for other in [s for s in sets if s & tied]:
            sets.remove(other)
            tied |= other
        sets.append(tied)
    return [sorted((names[i] for i in s), key=names.index) for s in sets]


def sentences(sets: list[list[str]]) -> list[str]:
    """The same in words."""
    texts = []
    for names in sets:
        if len(names) == 1:
            texts.append(f"these readings do not tell {names[0]}")
        elif len(names) == 2:
            texts.append(f"these readings can not part {names[0]} from {names[1]}")
        else:
            texts.append(
                f"these readings can not part {', '.join(names[:-1])} and {names[-1]} from each"
                " other"
            )
    return texts
