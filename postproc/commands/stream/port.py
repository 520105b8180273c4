"""A serial port, a pseudo-terminal, socket://host:port or rfc2217://host:port, as bytes that do not
wait."""

from __future__ import annotations

import contextlib
import re
import select
import socket
import time
from typing import Any

from postproc.errors import UsageError

ERRNO = re.compile(r"\[Errno \d+\] ([^:'\[]+)")
SERIAL = (
    "is it plugged in, is its name right, may you use it (group dialout), and does no other"
    " program hold it?"
)
NETWORK = (
    "is the device on, are its name and number right, and is no other program connected to it?"
)
LOOK = 0.02  # s that a read takes at most, where there is nothing to select on


class Lost(Exception):
    """The other end is gone: unplugged, closed, or the line was cut. One thing, whatever the system
    calls it."""


class Port:
    """read(timeout) and write(data) raise Lost. write takes what the system takes at once, and says
    how much.

    frame: data bits, parity (E, O, N) and stop bits. rtscts: whether the RTS and CTS wires say when
    bytes may leave. wakes: what ends a read when it becomes readable: a signal has come.
    """

    wakes: socket.socket | None = None

    def __init__(
        self,
        url: str,
        baud: int,
        reset: bool = True,
        frame: tuple[int, str, int] = (8, "N", 1),
        rtscts: bool = False,
    ):
        try:
            import serial
        except ImportError:
            raise UsageError("gcomp stream needs pyserial", "pip install pyserial") from None
        self._broken: tuple[type[BaseException], ...] = (
            serial.SerialException,
            OSError,
            TypeError,
            ValueError,
        )
        try:
            port: Any = serial.serial_for_url(url, do_not_open=True)
            port.baudrate, port.timeout = baud, 0
            if url.lower().startswith(
                "rfc2217:"
            ):  # whose writes can not time out, and which negotiates anew at every change
                port.timeout = LOOK
            else:
                port.write_timeout = 0
            port.bytesize, port.parity, port.stopbits = frame
            port.rtscts = rtscts
            with contextlib.suppress(AttributeError, ValueError):
                # a second program on the port would take answers away, and every count would be
                # wrong
                port.exclusive = True
            if not reset:  # raising DTR restarts boards of the Arduino kind
                port.dtr = port.rts = False
            port.open()
        except (serial.SerialException, OSError, ValueError) as error:
            raise UsageError(
                f"the port {url} can not be opened: {_plain(error)}",
                NETWORK if "://" in url else SERIAL,
            ) from None
        self._port, self.url = port, url
        # Behind a network nobody can wait until a byte has left: it is told by the clock.
        bits, parity, stop = frame
        # a start bit, the data, the parity and the stop bits
        self._byte = (1 + bits + (parity != "N") + stop) / baud if "://" in url else 0.0  # s
        self._left = 0.0  # when the last byte has left
        self._fd: int | None = None
        with contextlib.suppress(AttributeError, OSError, ValueError):
            self._fd = int(port.fileno())
        if self._fd is None:
            port.timeout = LOOK

    def read(self, timeout: float) -> bytes:
        """Whatever has come, after `timeout` s at most."""
        try:
            if self._fd is not None:
                if not self._readable(self._fd, timeout):
                    return b""
            else:
                if timeout < LOOK and not self._port.in_waiting:
                    time.sleep(timeout)
                    if not self._port.in_waiting:
                        return b""
                first: bytes = self._port.read(1)
                return first + (self._port.read(self._port.in_waiting) if first else b"")
            data: bytes = self._port.read(4096)
        except self._broken as error:
            raise Lost(_reason(error)) from None
        if not data and self._fd is not None:  # readable, and nothing there: hung up
            raise Lost("the device is gone")
        return data

    def _readable(self, fd: int, timeout: float) -> bool:
        """Whether something has come within `timeout` s, or until a signal came."""
        wakes = self.wakes
        waits: list[Any] = [fd] if wakes is None else [fd, wakes]
        ready = select.select(waits, [], [], timeout)[0]
        if wakes is not None and wakes in ready:
            wakes.recv(64)
        return fd in ready

    def write(self, data: bytes) -> int:
        try:
            # 0 bytes now, rather than waiting: the loop must look at signals and answers meanwhile
            if self._fd is not None and not select.select([], [self._fd], [], 0)[1]:
                return 0
            n = int(self._port.write(data) or 0)
            self._left = max(self._left, time.monotonic()) + n * self._byte
            return n
        except self._broken as error:
            raise Lost(_reason(error)) from None

    def drain(self) -> None:
        """Wait until what was written has left: for links on which the other side may say stop at
        any byte. Behind a network that is as long as the line takes for it."""
        if self._byte:
            time.sleep(max(0.0, self._left - time.monotonic()))
        try:
            self._port.flush()
        except self._broken as error:
            raise Lost(_reason(error)) from None

    def close(self) -> None:
        with contextlib.suppress(*self._broken):
            self._port.close()


def _reason(error: BaseException) -> str:
    return getattr(error, "strerror", None) or str(error) or "the device is gone"


def _plain(error: BaseException) -> str:
    """The system's own words, without the names that pyserial puts around them."""
    text = getattr(error, "strerror", None) or str(error)
    found = ERRNO.findall(str(error))
    return found[-1].strip() if found else text
