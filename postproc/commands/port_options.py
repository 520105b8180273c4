"""The options of a port, for every command that speaks over one."""

from __future__ import annotations

import argparse


def port(parser: argparse._ActionsContainer) -> None:
    """Which one it is."""
    parser.add_argument(
        "--port",
        metavar="PORT",
        help=(
            "/dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port; auto: the only one"
            " there is"
        ),
    )


def boards(parser: argparse._ActionsContainer) -> None:
    """Of a controller that says what it is, on a board that opening the port may restart."""
    parser.add_argument(
        "--list-ports",
        action="store_true",
        help="the serial ports of this computer, with what is plugged in",
    )
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
