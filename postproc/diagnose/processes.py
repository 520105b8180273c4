"""Sets with one more process: what comes back in a unit and has no name."""

from __future__ import annotations

from postproc.diagnose.sets import Found, Sets


def more(sets: Sets, state: Found, count: int) -> list[Found]:
    """The sets with one more process that promise most, at most `count` of them. What is worth
    nothing after one step is not worth its cost after several, nor beside further processes."""
    state = sets.at_own_form(state)
    tried = {
        (u, kind): state.fit.on | {(u, kind)}
        for u, part in enumerate(sets.evidence.parts)
        for kind, columns in part.processes.items()
        if columns.any()
        and (u, kind) not in state.fit.on
        and (state.members, (u, kind)) not in sets.hopeless
    }
    # One step of learning each, from what the set has learned already: a ranking, no score. The few
    # best are learned to the end by sets.of().
    worth = {
        process: sets.evidence.learn(state.fit.chosen, state.fit, on, 1, state.least).value
        for process, on in tried.items()
    }
    # without its cost even: what gains nothing by itself gains nothing beside others of its kind
    hopeful = [process for process in tried if worth[process] > state.fit.value]
    sets.hopeless |= {(state.members, process) for process in tried.keys() - set(hopeful)}
    best = sorted(hopeful, key=lambda process: -worth[process])[:count]
    return [sets.of(state.members, tried[process], state) for process in best]
