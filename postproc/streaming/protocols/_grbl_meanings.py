"""What GRBL's numbers mean, in short. Source: gnea/grbl, doc/markdown/interface.md (response and alarm messages)."""

ERRORS = {
    1: "a word without its letter", 2: "a number is bad or missing", 3: "unknown $ command", 4: "a negative value",
    5: "homing is not enabled", 6: "step pulse too short", 7: "EEPROM could not be read, defaults restored",
    8: "allowed only when idle", 9: "locked: alarm or jogging", 10: "soft limits need homing", 11: "line too long",
    12: "beyond the step rate", 13: "safety door open", 14: "line too long for the EEPROM", 15: "jog leaves the travel",
    16: "bad jog command", 17: "laser mode needs PWM", 20: "unknown or unsupported code",
    21: "two codes of one modal group", 22: "no feed rate yet", 23: "the code needs a whole number",
    24: "two codes that both need axis words", 25: "a word twice", 26: "axis words are missing", 27: "bad N number",
    28: "P or L is missing", 29: "no such work offset", 30: "G53 needs G0 or G1", 31: "axis words that nothing uses",
    32: "an arc without axis words in its plane", 33: "the target can not be reached so", 34: "the arc's radius does not fit",
    35: "the arc has no centre", 36: "words that nothing uses", 37: "tool length along another axis", 38: "tool number too large",
}  # fmt: skip
ALARMS = {
    1: "a limit switch was hit; the position is likely lost, home again",
    2: "the target lies outside the travel; the position is kept",
    3: "reset while moving; steps may be lost, home again",
    4: "the probe was not as expected before probing",
    5: "the probe touched nothing",
    6: "homing was reset",
    7: "the door was opened while homing",
    8: "homing could not clear the switch",
    9: "homing found no switch",
    10: "an emergency stop",
}
