"""The options of a port, for every command that speaks over one."""

PORT = """\
--port PORT  /dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port; auto: the only one there
    is"""

# of a controller that says what it is, on a board that opening the port may restart
BOARDS = """\
--list-ports  the serial ports of this computer, with what is plugged in
--protocol NAME  default auto: by what the controller says
--no-reset-on-open  keep DTR low, so that the board is not restarted"""
