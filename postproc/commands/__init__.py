"""Subcommands. One file each, found by its name: HELP, `arguments(parser)` and `run(options) ->
exit status`."""
