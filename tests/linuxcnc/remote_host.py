"""LinuxCNC without a display behind its own remote interface: `/usr/bin/python3.11 remote_host.py
FOLDER '{...}'`.

Run by remote.py in namespaces of its own, never imported by a test. Starts what headless_host.py
starts, and linuxcncrsh, which listens on TCP 5007 in there; its bytes go through standard input and
output. The joints are written to FOLDER/joints while it runs: time, x, y, z (s, mm), as LinuxCNC's
feedback has them, a line whenever they change."""

import contextlib
import json
import os
import select
import socket
import subprocess
import sys
import threading
import time

import headless_host as host

PORT = 5007


def connected():
    """A connection to linuxcncrsh, once it listens."""
    until = time.monotonic() + host.START
    while True:
        try:
            return socket.create_connection(("127.0.0.1", PORT))
        except OSError:
            if time.monotonic() > until:
                raise host.Trouble("linuxcncrsh does not listen") from None
            time.sleep(0.05)


def watch(machine, path):
    """Write the joints down while the controller runs."""
    last = None
    with open(path, "w", buffering=1) as file:
        while True:
            machine.stat.poll()
            joints = machine.joints()
            if joints != last:
                last = joints
                print(f"{time.monotonic():.4f}", *(f"{v:.6f}" for v in joints), file=file)
            time.sleep(0.001)


def relay(peer):
    """Bytes to and fro until standard input ends."""
    with contextlib.suppress(OSError):
        while True:
            ready, _, _ = select.select([0, peer], [], [])
            if 0 in ready:
                data = os.read(0, 4096)
                if not data:
                    return
                peer.sendall(data)
            if peer in ready:
                data = peer.recv(4096)
                if not data:
                    return
                os.write(1, data)


def main(folder, settings):
    task = host.start(folder, settings.get("parameters", {}), settings.get("tools", {}))
    machine = host.Machine(task)
    if settings.get("prepared", True):
        machine.prepare()
        machine.command.feedrate(1.0)
    log = open("log", "a")
    shell = ["linuxcncrsh", "--", "-ini", host.INI]
    subprocess.Popen(shell, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
    threading.Thread(target=watch, args=(machine, "joints"), daemon=True).start()
    peer = connected()
    print("ready", file=sys.stderr, flush=True)
    relay(peer)


if __name__ == "__main__":
    try:
        main(sys.argv[1], json.loads(sys.argv[2]) if len(sys.argv) > 2 else {})
    except (host.Trouble, OSError, subprocess.SubprocessError) as trouble:
        print(f"LinuxCNC does not start: {trouble}", file=sys.stderr, flush=True)
