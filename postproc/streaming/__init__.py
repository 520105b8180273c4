"""Compensated lines to a controller: bytes and time in, bytes and events out. No port, no clock, no
thread.

    source.py     program text through the filter; every wire line knows its source line, block and
                  correction
    compact.py    the same words in fewer bytes
    rates.py      what the link must carry, how long the job will take
    protocols/    one file a protocol: how lines leave, what answers mean
    greeting.py   the talk before the job: who is there, what it says of itself
    live.py       zeros, tool length and modal state of the controller, told to the filter
    limits.py     how long it waits before it draws a conclusion
    outcome.py    how a job ends: kinds, exit statuses, messages
    sender.py     the job: window, answers, hold, stop, and the one outcome
    journal.py    what was sent and answered, as lines that survive a crash
    restart.py    the way back into a program that was interrupted
    path.py       does the machine stand on the path of what it was sent?
    trace.py      reported positions as rows of a recording

postproc/commands/stream opens the port, owns the clock, and moves bytes between the two.
"""
