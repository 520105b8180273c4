"""`gcomp receive -o FILE --port P`: take a program that a control sends over RS-232, whole or not at all."""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from postproc.errors import UsageError

if TYPE_CHECKING:
    from postproc.streaming.reception import Reception

HELP = (
    "receive a program that a control sends (its PUNCH or SEND key), and check every byte's parity"
)
EXAMPLE = "gcomp receive --port /dev/ttyUSB0 --protocol dnc-haas -o O1234.nc"
DAMAGED, LOST, STOPPED = 16, 13, 130  # exit statuses
WAIT, TELL = 0.1, 1.0  # s
SILENCE = 5.0  # s without a byte, behind which a program that began will not go on


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--port",
        metavar="PORT",
        help="/dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port; auto: the only one",
    )
    parser.add_argument(
        "--protocol",
        default="dnc",
        metavar="NAME",
        help="dnc (Fanuc, default), dnc-haas, dnc-siemens",
    )
    parser.add_argument("--baud", type=int, help="default: the control's common speed")
    parser.add_argument("--frame", metavar="7E2", help="default: the control's common frame")
    parser.add_argument(
        "--rtscts", action="store_true", help="the wires RTS and CTS say when bytes may come"
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="where the program goes; it is not there before it is whole",
    )
    parser.add_argument("--force", action="store_true", help="replace FILE if it is there")
    parser.add_argument(
        "--until-silence",
        action="store_true",
        help=f"this control ends a program with neither %% nor DC4: {SILENCE:g} s without a byte are its end",
    )
    parser.add_argument("--quiet", action="store_true", help="no progress")


def run(options: argparse.Namespace) -> int:
    from postproc.commands.stream import _line, ports_found
    from postproc.commands.stream.port import Lost, Port
    from postproc.streaming.reception import Reception

    if not options.output:
        raise UsageError("where shall the program go? -o FILE is missing", EXAMPLE)
    if not options.protocol.startswith("dnc"):
        raise UsageError(
            f"--protocol {options.protocol} sends no programs", "dnc, dnc-haas, dnc-siemens"
        )
    if Path(options.output).exists() and not options.force:
        raise UsageError(
            f"{options.output} is there already", "another name, or --force to replace it"
        )
    bits, parity, stop = _line(options)
    url = ports_found.chosen(options.port)
    raw = bits == 7 and parity != "N" and "://" not in url  # each byte's parity can be looked at
    port = Port(
        url,
        options.baud,
        frame=(8, "N", stop) if raw else (bits, parity, stop),
        rtscts=options.rtscts,
    )
    reception = Reception(bits == 7, parity if raw else "N")
    try:
        _take(port, reception, options)
    except KeyboardInterrupt:
        return _ended(reception, "interrupted", STOPPED)
    except Lost as error:
        return _ended(reception, f"the connection is lost: {error}", LOST)
    finally:
        port.close()
    if reception.fault:
        return _ended(reception, reception.fault, DAMAGED)
    _written(Path(options.output), reception.text)
    print(
        f"gcomp: {options.output}: {reception.lines} lines, {reception.size} bytes received",
        file=sys.stderr,
    )
    return 0


def _take(port, reception: Reception, options: argparse.Namespace) -> None:
    """Until it is whole, or will not be."""
    from postproc.commands.stream.outlets import Outlet

    out = Outlet(sys.stdout)
    terminal = sys.stderr is not None and sys.stderr.isatty()
    err = Outlet(sys.stderr)
    heard, told = time.monotonic(), 0.0
    if not options.quiet:
        err.say(
            f"gcomp: {options.port}, {options.baud} baud: waiting for the control; start the output there"
        )
    while not (reception.done or reception.fault):
        data = port.read(WAIT)
        now = time.monotonic()
        heard = now if data else heard
        reception.receive(data)
        if now - heard > SILENCE:
            reception.silent(options.until_silence)
        if now - told > TELL and not options.quiet and not (out.stalls() or err.stalls()):
            told = now
            state = "receiving" if reception.begun else "waiting"
            if terminal:
                err.say(f"gcomp: {state}, {reception.size} bytes, {reception.lines} lines")
            else:
                fields = {
                    "event": "progress",
                    "state": state,
                    "bytes": reception.size,
                    "lines": reception.lines,
                }
                out.say(json.dumps(fields))
    out.close()
    err.close()


def _ended(reception: Reception, why: str, status: int) -> int:
    """Without a program."""
    print(
        f"gcomp: nothing was written: {why} ({reception.size} bytes, {reception.lines} lines had come in)",
        file=sys.stderr,
    )
    if status == DAMAGED:
        print(
            "    compare speed, data bits, parity and stop bits with the control's (--baud, --frame), look at the cable, and send it again; "
            "a control that ends with neither % nor DC4: --until-silence", file=sys.stderr,
        )  # fmt: skip
    return status


def _written(path: Path, text: bytes) -> None:
    """Whole or not at all. Raises UsageError."""
    part = path.with_name(path.name + ".part")
    try:
        part.write_bytes(text)
        os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise UsageError(
            f"{path} can not be written: {error.strerror}", "-o FILE elsewhere"
        ) from None
