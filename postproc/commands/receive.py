"""`gcomp receive -o FILE --port P`: take a program that a control sends over RS-232, whole or not
at all."""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from postproc import colour, ports, standing
from postproc.commands import as_json, option_text, port_options
from postproc.errors import UsageError

if TYPE_CHECKING:
    from postproc.commands.stream.outlets import Outlet
    from postproc.streaming.reception import Reception

HELP = (
    "receive a program that a control sends (its PUNCH or SEND key), and check every byte's parity"
)
EXAMPLE = "gcomp receive --port /dev/ttyUSB0 --protocol dnc-haas -o O1234.nc"
FORMAT = "gcomp-receive/1"
DAMAGED, LOST, STOPPED = 16, 13, 130  # exit statuses
WAIT, TELL = 0.1, 1.0  # s
SILENCE = 5.0  # s without a byte, behind which a program that began will not go on


OPTIONS = f"""
{port_options.PORT}
--protocol NAME  dnc (Fanuc, default), dnc-haas, dnc-siemens
--baud BAUD  default: the control's common speed
--frame 7E2  default: the control's common frame
--rtscts  the wires RTS and CTS say when bytes may come
-o, --output FILE  where the program goes; it is not there before it is whole
--force  replace FILE if it is there
--until-silence  this control ends a program with neither %% nor DC4: {SILENCE:g} s without a byte
    are its end
--quiet  no progress
--json FILE  all of it as JSON ({FORMAT}); - for standard output
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(parser, OPTIONS, protocol="dnc", baud=int)


def run(options: argparse.Namespace) -> int:
    from postproc.commands.stream import options as stream_options
    from postproc.commands.stream import ports_found
    from postproc.commands.stream.port import Lost, Port
    from postproc.streaming.reception import Reception

    if not options.output:
        raise UsageError("where shall the program go? -o FILE is missing", EXAMPLE)
    if not options.protocol.startswith("dnc"):
        raise UsageError(
            f"--protocol {options.protocol} sends no programs", "dnc, dnc-haas, dnc-siemens"
        )
    standing.kept(options.output, options.force)
    ports.writable(Path(options.output))
    bits, parity, stop = frame = stream_options.frame(options)
    url = ports_found.chosen(options.port)
    looked_at = "N"  # the parity of each byte
    if bits == 7 and "://" not in url and parity != "N":
        # A port that checks parity may drop a damaged byte or let it pass as another: with 8 bits
        # each one comes in, and Reception looks at its eighth.
        frame, looked_at = (8, "N", stop), parity
    port = Port(url, options.baud, frame=frame, rtscts=options.rtscts)
    reception = Reception(bits == 7, looked_at)
    try:
        _take(port, reception, options)
        why, status = reception.fault, DAMAGED if reception.fault else 0
    except KeyboardInterrupt:
        why, status = "interrupted", STOPPED
    except Lost as error:
        why, status = f"the connection is lost: {error}", LOST
    finally:
        port.close()
    if status:
        _ended(reception, why, status)
    else:
        ports.write_whole(options.output, reception.text)
        print(
            f"gcomp: {options.output}: {reception.lines} lines, {reception.size} bytes received",
            file=sys.stderr,
        )
    as_json.put(options.json, _report(options, url, reception, why))
    return status


def _report(
    options: argparse.Namespace, url: str, reception: Reception, why: str
) -> dict[str, object]:
    return {
        "format": FORMAT, "port": url, "protocol": options.protocol, "baud": options.baud,
        "bytes": reception.size, "lines": reception.lines, "fault": why or None,
        "written": None if why else options.output,
    }  # fmt: skip


def _take(port, reception: Reception, options: argparse.Namespace) -> None:
    """Until it is whole, or will not be."""
    from postproc.commands.stream.outlets import Outlet

    out, err = Outlet(sys.stdout), Outlet(sys.stderr)
    heard, last_said = time.monotonic(), 0.0
    if not options.quiet:
        err.say(
            f"gcomp: {options.port}, {options.baud} baud: waiting for the control; start the output"
            " there"
        )
    while not (reception.done or reception.fault):
        data = port.read(WAIT)
        now = time.monotonic()
        heard = now if data else heard
        reception.receive(data)
        if now - heard > SILENCE:
            reception.silent(options.until_silence)
        if now - last_said > TELL and not options.quiet and not (out.stalls() or err.stalls()):
            last_said = now
            _say_progress(reception, out, err, options.json == "-")
    out.close()
    err.close()


def _say_progress(reception: Reception, out: Outlet, err: Outlet, taken: bool) -> None:
    """To a terminal for a person, else as JSON; taken: standard output is for another document."""
    state = "receiving" if reception.started else "waiting"
    if sys.stderr is not None and sys.stderr.isatty():
        err.say(f"gcomp: {state}, {reception.size} bytes, {reception.lines} lines")
    elif not taken:
        fields = {
            "event": "progress",
            "state": state,
            "bytes": reception.size,
            "lines": reception.lines,
        }
        out.say(json.dumps(fields))


def _ended(reception: Reception, why: str, status: int) -> None:
    """Without a program."""
    colour.fault(
        f"nothing was written: {why} ({reception.size} bytes, {reception.lines} lines had come in)"
    )
    if status == DAMAGED:
        print(
            "    compare speed, data bits, parity and stop bits with the control's (--baud,"
            " --frame), look at the cable, and send it again; a control that ends with neither %"
            " nor DC4: --until-silence",
            file=sys.stderr,
        )
