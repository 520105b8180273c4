"""Subcommands. One file each, found by its name: HELP, one line; `arguments(parser)`, most often by
OPTIONS, the options as their users read them (option_text.py); `run(options) -> exit status`; and
EXAMPLE, where there is one, a line that `--help` ends with."""
