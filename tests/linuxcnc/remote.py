"""LinuxCNC behind its own remote interface (linuxcncrsh), on a TCP port of this computer: `with
Remote() as r: r.path`."""

import contextlib
import json
import os
import select
import socket
import subprocess
import tempfile
import threading
from pathlib import Path

from tests.linuxcnc import headless

HERE = Path(__file__).parent
LOOPBACK = headless.OVERLAY.replace("cd /", "ip link set lo up && cd /")


def available():
    """None, or why it can not run here."""
    why = headless.available()
    if why is None and not (headless.CACHE / "usr/bin/linuxcncrsh").exists():
        return "linuxcncrsh is not in the cache: sh tests/linuxcnc/fetch_headless.sh (22 MB)"
    return why


class Remote:
    """`path` is the port for one client. prepared: out of emergency stop, on and homed."""

    def __init__(self, parameters=None, tools=None, prepared=True):
        self.settings = {"parameters": parameters or {}, "tools": tools or {}, "prepared": prepared}
        self.server = socket.create_server(("127.0.0.1", 0))
        self.path = f"socket://127.0.0.1:{self.server.getsockname()[1]}"

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory(prefix="gcomp-")
        host = str(HERE / "remote_host.py")
        command = ["/usr/bin/python3.11", host, self.folder.name, json.dumps(self.settings)]
        self.process = subprocess.Popen(
            [*headless.OUTER, "sh", "-c", LOOPBACK, "sh", *map(str, command)], cwd=headless.CACHE,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            env={
                "HOME": self.folder.name, "PATH": "/usr/bin:/bin:/usr/sbin:/sbin",
                "LC_ALL": "C.UTF-8", "PYTHONDONTWRITEBYTECODE": "1",
            },
        )  # fmt: skip
        said = self.process.stderr.readline().decode()
        if said.strip() != "ready":
            self.__exit__()
            raise headless.Refused(said or "LinuxCNC ended")
        self._stop = False
        threading.Thread(target=self._serve, daemon=True).start()
        return self

    def __exit__(self, *_):
        self._stop = True
        self.server.close()
        self.process.stdin.close()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.folder.cleanup()

    def _serve(self):
        """One client after the other; for linuxcncrsh they are one."""
        with contextlib.suppress(OSError, ValueError):
            while not self._stop:
                peer = self.server.accept()[0]
                with peer:
                    self._carry(peer)

    def _carry(self, peer):
        inner, outer = self.process.stdin.fileno(), self.process.stdout.fileno()
        while not self._stop:
            for ready in select.select([peer, outer], [], [], 0.1)[0]:
                data = peer.recv(4096) if ready is peer else os.read(outer, 4096)
                if not data:
                    return
                if ready is peer:
                    os.write(inner, data)
                else:
                    peer.sendall(data)

    def joints(self):
        """[(s, x, y, z)]: where the joints have been."""
        text = (Path(self.folder.name) / "joints").read_text()
        return [tuple(map(float, row.split())) for row in text.split("\n")[:-1]]
