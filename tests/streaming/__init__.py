"""Streaming: the number of a claim stands in the names of its tests (`pytest -k A8_`).

A1 the bytes of the file arrive, any cut of the input, 10,000 lines, memory
A2 window as announced, never overrun, kept full
A3 the wire is full at 115,200 baud
A4 what is an answer, and what is not
A5 refused lines: stop, continue, ask
A6 EEPROM lines go alone
A7 comments, long lines, realtime bytes
A8 hold, resume, stop; holds of others
A9 restart of the controller
A10 closed port, silence, kill -9, slow disk
A11 restart from a line or a journal
A12 stalls, and what is none
A13 numbers, checksums, resends
A14 drip feed: frames, stop at any byte, RTS/CTS
A15 check mode
A16 done is said last, exit statuses
A17 every wire line knows its source; the journal replayed is the file
A18 without a terminal: pipe, JSON lines, time left, SIGTERM
A19 lines a second, compact form
A20 seeded faults; the path under watch
"""
