"""`gcomp control --port P ORDER`: what is needed between jobs, so that no other program is: reset,
resume, unlock, home, jog, zero, send."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from typing import TYPE_CHECKING, Any

from postproc.commands import as_json, option_text, port_options
from postproc.streaming.orders import WORDS

if TYPE_CHECKING:
    from postproc.streaming.events import Status

HELP = "talk to a controller between jobs: its state, reset, resume, unlock, home, jog, zero, send"
EXAMPLE = "gcomp control --port /dev/ttyUSB0 jog Z5 F300"
FORMAT = "gcomp-control/1"
STATE = "state"
STOPPED, REFUSED, LONGEST = 130, 10, 600.0  # exit statuses; s that an order may take


OPTIONS = f"""
{port_options.PORT}
{port_options.BOARDS}
--baud BAUD  default 115200
order? ({"|".join((STATE, *WORDS))})  left out: state, with the order that leads out of it
words* WORD  jog X10 Y-5 F800 (mm from here, mm/min); zero X Y; send '$$'
--json FILE  all of it as JSON ({FORMAT}); - for standard output
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    option_text.add(parser, OPTIONS, protocol="auto", baud=(int, 115200))


def run(options: argparse.Namespace) -> int:
    from postproc.commands.stream import ports_found
    from postproc.commands.stream.port import Port
    from postproc.streaming import orders

    if options.list_ports:
        print(ports_found.listed(), file=as_json.beside(options.json))
        ports = [{"port": p.device, "text": ports_found.words(p)} for p in ports_found.found()]
        as_json.put(options.json, {"format": FORMAT, "ports": ports})
        return 0
    if options.order == STATE:
        options.order = None
    if options.order:
        # before a port is opened, which restarts some boards
        orders.line_of(options.order, options.words)
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
    from postproc.streaming.orders import Order, in_words

    greeting = Greeting(options.protocol, state_only=True, port=url)
    loop.greet(port, greeting)
    assert greeting.protocol is not None
    out = as_json.beside(options.json)
    if options.order is None:
        print(
            in_words(greeting.status, url)
            if greeting.status
            else "this controller does not report its state",
            file=out,
        )
        as_json.put(options.json, _found(options, url, greeting.status))
        return 0
    order = Order(greeting.protocol, options.order, options.words, greeting.status, url)
    try:
        order.begin(time.monotonic())
        loop.carry(port, order, LONGEST)
    except KeyboardInterrupt:
        with contextlib.suppress(OSError):
            port.write(greeting.protocol.urgent("hold") + greeting.protocol.urgent("jog cancel"))
        print("gcomp: interrupted; the controller was told to hold", file=sys.stderr)
        return STOPPED
    for text in order.said:
        print(text, file=out)
    as_json.put(
        options.json,
        _found(options, url, order.status) | {"said": order.said, "fault": order.fault or None},
    )
    if order.fault:
        print(f"gcomp: the controller refused it: {order.fault}", file=sys.stderr)
        if order.status:
            print(f"gcomp: {in_words(order.status, url)}", file=sys.stderr)
        return REFUSED
    if order.status:
        print(in_words(order.status, url), file=out)
    return 0


def _found(options: argparse.Namespace, url: str, status: Status | None) -> dict[str, Any]:
    """An order, and the controller's state behind it."""
    from postproc.streaming.orders import in_words

    found: dict[str, Any] = {"format": FORMAT, "port": url, "order": options.order}
    found |= {"words": options.words, "said": [], "fault": None, "state": None}
    if status is not None:
        place = None if status.place is None else list(status.place)
        found["state"] = {
            "name": status.state,
            "detail": status.detail,
            "place_mm": place,
            "feed_mm_min": status.feed,
            "text": in_words(status, url),
        }
    return found
