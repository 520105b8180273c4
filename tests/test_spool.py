"""What is kept until a program is accepted: the same bytes, in memory or on disk."""

from __future__ import annotations

import io

from postproc import ports


def test_a_spool_that_outgrows_memory_keeps_its_bytes():
    part = bytes(range(256)) * 4096
    few, many = ports.spool(), ports.spool()
    few.write(part)
    with many:
        for _ in range(ports.IN_MEMORY // len(part) + 2):
            many.write(part)
        many.seek(len(part))
        many.write(b"changed")  # on disk it is written where it stands, too
        many.seek(0)
        data = many.read()
        size = (ports.IN_MEMORY // len(part) + 2) * len(part)
        assert len(data) == size
        changed = part + b"changed" + part[7:]
        assert data == changed + part * (size // len(part) - 2)
    few.seek(0)
    assert few.read() == part and isinstance(few._file, io.BytesIO)
    assert not isinstance(many._file, io.BytesIO)


def test_a_spool_gives_its_lines_each_time_anew():
    with ports.spool() as spool:
        spool.write(b"G0 X1\nG0 X2\n")
        for _ in range(2):
            spool.seek(0)
            assert list(spool) == [b"G0 X1\n", b"G0 X2\n"]
