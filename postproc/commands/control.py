"""`gcomp control --port P ORDER`: what is needed between jobs, so that no other program is: reset, resume, unlock, home, jog, zero, send."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time

from postproc.errors import UsageError

HELP = "talk to a controller between jobs: its state, reset, resume, unlock, home, jog, zero, send"
EXAMPLE = "gcomp control --port /dev/ttyUSB0 jog Z5 F300"
STOPPED, REFUSED, LONGEST = 130, 10, 600.0  # exit statuses; s that an order may take


def arguments(parser: argparse.ArgumentParser) -> None:
    from postproc.streaming.orders import WORDS

    parser.add_argument(
        "--port",
        metavar="PORT",
        help="/dev/ttyUSB0, COM3, socket://host:port; auto: the only one that there is",
    )
    parser.add_argument(
        "--list-ports",
        action="store_true",
        help="the serial ports of this computer, with what is plugged in",
    )
    parser.add_argument("--baud", type=int, default=115200, help="default 115200")
    parser.add_argument(
        "--protocol",
        default="auto",
        metavar="NAME",
        help="default auto: by what the controller says",
    )
    parser.add_argument(
        "--no-reset-on-open",
        action="store_true",
        help="keep DTR low, so that the board is not restarted",
    )
    parser.add_argument(
        "order",
        nargs="?",
        choices=WORDS,
        help="left out: the controller's state, and the order that leads out of it",
    )
    parser.add_argument(
        "words",
        nargs="*",
        metavar="WORD",
        help="jog X10 Y-5 F800 (mm from here, mm/min); zero X Y; send '$$'",
    )


def run(options: argparse.Namespace) -> int:
    from postproc.commands.stream import ports_found
    from postproc.commands.stream.port import Port
    from postproc.streaming import orders

    if options.list_ports:
        print(ports_found.listed())
        return 0
    if options.order:
        orders.line_of(
            options.order, options.words
        )  # before a port is opened, which restarts some boards
    url = ports_found.chosen(options.port)
    port = Port(url, options.baud, reset=not options.no_reset_on_open)
    try:
        return _carried_out(port, options, url)
    finally:
        port.close()


def _carried_out(port, options: argparse.Namespace, url: str) -> int:
    """The order, to its end; the state behind it is told."""
    from postproc.commands.stream import loop
    from postproc.streaming.greeting import Greeting
    from postproc.streaming.orders import Order, told

    greeting = Greeting(options.protocol, state_only=True)
    loop.greet(port, greeting)
    assert greeting.protocol is not None
    if options.order is None:
        print(
            told(greeting.status, url)
            if greeting.status
            else "this controller does not report its state"
        )
        return 0
    order = Order(greeting.protocol, options.order, options.words, greeting.status)
    try:
        _loop(port, order)
    except KeyboardInterrupt:
        with contextlib.suppress(OSError):
            port.write(greeting.protocol.urgent("hold") + greeting.protocol.urgent("jog cancel"))
        print("gcomp: interrupted; the controller was told to hold", file=sys.stderr)
        return STOPPED
    for text in order.said:
        print(text)
    if order.fault:
        print(f"gcomp: the controller refused it: {order.fault}", file=sys.stderr)
        if order.status:
            print(f"gcomp: {told(order.status, url)}", file=sys.stderr)
        return REFUSED
    if order.status:
        print(told(order.status, url))
    return 0


def _loop(port, order) -> None:
    """Carry bytes until it is done, refused, or silent for too long. Raises UsageError."""
    from postproc.commands.stream.loop import WAIT
    from postproc.commands.stream.port import Lost

    begun = time.monotonic()
    order.begin(begun)
    try:
        while not (order.done or order.fault):
            now = time.monotonic()
            order.tick(now)
            data = order.bytes_out()
            while data:
                data = data[port.write(data) :]
            order.receive(port.read(WAIT), time.monotonic())
            if now - begun > LONGEST:
                raise UsageError(
                    f"the controller has not finished within {LONGEST:g} s", "look at the machine"
                )
    except Lost as error:
        raise UsageError(
            f"the port {port.url} was closed: {error}", "is the controller still plugged in?"
        ) from None
