"""What is usually wrong with a calibration, one check a file, found by its name: check(calibration)
-> [Finding].

Each has a number and plain words. None changes a value.
"""
