"""Heat over time: which temperature each block of a program meets, by the program's own clock.

log: what a thermometer wrote; clock: when a block is executed (feeds, rapids, dwells); follow: both
together, as numbers of the machine's drivers (machine/growth.py). Text and physics meet here, as in
filter.py; nothing here opens a file.
"""
