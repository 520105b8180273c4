"""Streaming, judged by the step pulses of a real GRBL 1.1h image: `python -m proof.streaming`.

What the campaigns gave; jobs in which the simulator lost more than 0.5 s were repeated.

    whole        short pieces to F5000, arcs in three planes, a helix, inch, G91, three axes, pecks,
                 G55, lines without a block: every place, 0.5 mm apart at most, in order within a
                 step and a half
    interrupted  held and resumed, stopped in a hold, killed, unplugged, reset in motion, without
                 power, reset by its button, at random lines: more than 10 motions cut twice only
                 where a path lies upon itself
    faults       lost answers and bytes, flipped bits, silence, cable, power, buttons, late answers:
                 29 done, 16 refused lines, 18 lost connections, 11 stalls, 11 alarms, 11 resets, 4
                 beside the path or with answers miscounted

On the models of the tests: GRBL 1.1, 1,000 runs with faults, echo on: 443 done; 331 altered bytes,
93 disconnections, 64 alarms, 53 resets and 16 stalls reported. 1,000 restarts with power cuts that
lose the zero: 503 done; no motion left out, at most 6 made twice. Marlin with a damaged byte
towards the host: printcore hung in 6 of 10 jobs, and with a restart called 10 of 10 broken jobs
done; gcomp neither.
"""
