"""OctoPrint's virtual printer behind a pseudo-terminal, run by OctoPrint's own interpreter: `python
octoprint_host.py FOLDER [JSON]`.

FOLDER takes OctoPrint's files; JSON overrides settings of the plugin. Prints the port's name, then
every command that the printer handles, and ends when standard input is closed. Nothing of gcomp is
imported here.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import sys
import threading
import time
import tty
from pathlib import Path


def taken(printer, data: bytes) -> int:
    """How many bytes it took. Its write keeps a lock while it waits for room, and a request for a
    line needs the same lock (virtual.py, write and _triggerResend): neither goes on until write
    gives up, which then has taken nothing. The bytes wait on the wire meanwhile, as USB has
    them."""
    from serial import SerialTimeoutException

    try:
        return printer.write(data)
    except SerialTimeoutException:
        time.sleep(0.01)  # without the lock
        return 0


def main(folder: Path, override: dict) -> None:
    from octoprint.plugin import OctoPrintPlugin, plugin_manager
    from octoprint.settings import settings

    main_settings = settings(init=True, basedir=str(folder))
    plugin_manager(
        init=True, plugin_folders=[], plugin_bases=[OctoPrintPlugin], plugin_entry_points=[]
    )
    from octoprint.plugin import plugin_settings
    from octoprint.plugins.virtual_printer import VirtualPrinterPlugin
    from octoprint.plugins.virtual_printer.virtual import VirtualPrinter

    defaults = VirtualPrinterPlugin().get_settings_defaults() | {"throttle": 0} | override
    own = plugin_settings("virtual_printer", defaults=defaults, settings=main_settings)

    class Spy(VirtualPrinter):
        """Tells each command that it is about to handle."""

        def _gcode_G(self, code, data):
            print(f"G {data}", flush=True)
            return False

        def _gcode_M(self, code, data):
            print(f"M {data}", flush=True)
            return False

    class Profiles:
        def get_current_or_default(self):
            return {"extruder": {"count": 1}}

    data = folder / "data"
    data.mkdir(exist_ok=True)
    printer = Spy(own, Profiles(), str(data), read_timeout=0.05, write_timeout=0.05)
    master, slave = os.openpty()
    tty.setraw(slave)
    print(f"port {os.ttyname(slave)}", flush=True)
    stop = threading.Event()

    def back() -> None:
        while not stop.is_set():
            line = printer.readline()
            if line:
                with contextlib.suppress(OSError):
                    os.write(master, line if line.endswith(b"\n") else line + b"\n")

    threading.Thread(target=back, daemon=True).start()
    rest = b""
    while True:
        ready = select.select([master, sys.stdin], [], [])[0]
        if sys.stdin in ready and not sys.stdin.buffer.read1(1):
            break
        if master in ready:
            rest += os.read(master, 1024)
            *lines, rest = rest.split(b"\n")
            # it looks at one line of what is written at once: the next waits for more
            for line in lines:
                data_in = line + b"\n"
                while data_in:
                    data_in = data_in[taken(printer, data_in) :]
    stop.set()
    printer.close()
    os._exit(0)


if __name__ == "__main__":
    main(Path(sys.argv[1]), json.loads(sys.argv[2]) if len(sys.argv) > 2 else {})
