"""The serial ports of this computer, by name and by what is plugged in."""

from __future__ import annotations

from typing import Any

from postproc.errors import UsageError

AUTO = "auto"


def found() -> list[Any]:
    """Those with something behind them: a port of the board without a device says neither what it
    is nor whose."""
    try:
        from serial.tools import list_ports
    except ImportError:
        return []
    return sorted(
        (p for p in list_ports.comports() if p.vid is not None or p.hwid not in ("", "n/a")),
        key=lambda p: p.device,
    )


def words(port: Any) -> str:
    """A port in a line."""
    what = (
        port.description
        if port.description not in (None, "", "n/a", port.device)
        else "serial port"
    )
    maker = f", {port.manufacturer}" if getattr(port, "manufacturer", None) else ""
    number = f", serial number {port.serial_number}" if getattr(port, "serial_number", None) else ""
    return f"{port.device}  {what}{maker}{number}"


def listed() -> str:
    """All of them, a line each."""
    return (
        "\n".join(map(words, found()))
        or "no serial port is plugged in; socket://host:port needs none"
    )


def chosen(name: str | None) -> str:
    """The port that is meant. Raises UsageError where that is not certain."""
    if name is not None and name.lower() != AUTO:
        return name
    there = found()
    if name is not None and len(there) == 1:
        return str(there[0].device)
    if name is None:
        offer = " or ".join(p.device for p in there) or "/dev/ttyUSB0, COM3, socket://host:port"
        raise UsageError("--port is missing: where is the controller?", f"--port {offer}")
    if not there:
        raise UsageError(
            "--port auto: no serial port is plugged in", "--list-ports shows what there is"
        )
    raise UsageError(
        f"--port auto: there are {len(there)} ports, and which is meant is not certain",
        "name one of them: " + "; ".join(map(words, there)),
    )
