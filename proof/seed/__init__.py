"""The thesis' tables as an experiment: recordings, the machine without its tables, and what is
diagnosed from them."""
