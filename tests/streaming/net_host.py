"""The model behind a socket, in real time: bytes as they are (socket://), or RFC 2217 by pyserial's
own server side (rfc2217://)."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from types import SimpleNamespace

from tests.streaming.grbl_model import GrblModel


class NetHost:
    """`path` is the port. wire: what the client has set of the serial line behind the server.
    hang_up_after: lines received."""

    def __init__(self, model: GrblModel, rfc2217: bool, speed: float = 1.0, hang_up_after: int = 0):
        self.model, self.rfc2217, self.speed, self.hang_up_after = (
            model,
            rfc2217,
            speed,
            hang_up_after,
        )
        self.server = socket.create_server(("127.0.0.1", 0))
        self.path = (
            f"{'rfc2217' if rfc2217 else 'socket'}://127.0.0.1:{self.server.getsockname()[1]}"
        )
        self.wire = SimpleNamespace(
            baudrate=9600,
            bytesize=8,
            parity="N",
            stopbits=1,
            xonxoff=False,
            rtscts=False,
            dtr=None,
            rts=None,
            cts=True,
            dsr=True,
            ri=False,
            cd=False,
            reset_input_buffer=lambda: None,
            reset_output_buffer=lambda: None,
        )
        self._stop = False
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> NetHost:
        self._thread.start()
        return self

    def __exit__(self, *_) -> None:
        self._stop = True
        self.server.close()
        self._thread.join(5)

    def _run(self) -> None:
        with contextlib.suppress(OSError):
            peer = self.server.accept()[0]
            with peer:
                self._serve(peer)

    def _serve(self, peer: socket.socket) -> None:
        from serial import rfc2217

        manager = (
            rfc2217.PortManager(self.wire, SimpleNamespace(write=peer.sendall))
            if self.rfc2217
            else None
        )
        peer.settimeout(0.002)
        started = time.monotonic()
        while not self._stop:
            data = None
            with contextlib.suppress(TimeoutError):
                data = peer.recv(4096)
            if data == b"":
                break
            if self.hang_up_after and len(self.model.received) >= self.hang_up_after:
                return
            now = (time.monotonic() - started) * self.speed
            self.model.write(b"".join(manager.filter(data or b"")) if manager else data or b"", now)
            self.model.advance(now)
            back = self.model.read(now)
            if back:
                peer.sendall(b"".join(manager.escape(back)) if manager else back)
        while not self._stop:  # nobody is there any more; what has arrived is done all the same
            self.model.advance((time.monotonic() - started) * self.speed)
            time.sleep(0.002)
