"""Heat over time: which temperature each block of a program meets, by the program's own clock.

log: temperatures that a logger wrote; clock: when a block is executed (feeds, rapids, dwells);
course: the machine's drivers (temperatures, a spindle that warms up) at any moment of a batch;
follow: the value of each driver for each motion, in whole steps (machine/growth.py). Text and
physics meet here, as in filter.py; nothing here opens a file.
"""
