"""`gcomp completion bash|zsh|fish`: what a shell needs to complete commands, options, choices and
machines.

The script is made of the commands' own options, so that it says what they say; names of machines
are asked for when they are needed.
"""

from __future__ import annotations

import argparse
import importlib

HELP = "write what a shell needs to complete commands and options: gcomp completion bash"
EXAMPLE = "gcomp completion bash > ~/.local/share/bash-completion/completions/gcomp"
MACHINES = "gcomp machines 2>/dev/null | cut -d' ' -f1"

BASH = """# bash completion of gcomp; written by gcomp completion bash
_gcomp() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} command={default} options choices
    [ "$COMP_CWORD" -gt 1 ] && case ${{COMP_WORDS[1]}} in {names}) command=${{COMP_WORDS[1]}};; esac
    case $command in
{cases}
    esac
    case $before in
    --machine|--like|show) COMPREPLY=($(compgen -W "$({machines})" -- "$word") $(compgen -d -- "$word")); return;;
    esac
    case $command:$before in
{choices}
    esac
    if [[ $word == -* ]]; then COMPREPLY=($(compgen -W "$options" -- "$word"))
    elif [ "$COMP_CWORD" = 1 ]; then COMPREPLY=($(compgen -W "{commands}" -- "$word") $(compgen -f -- "$word"))
    else COMPREPLY=($(compgen -f -- "$word")); fi
}}
complete -o filenames -F _gcomp gcomp
"""  # noqa: E501


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=("bash", "zsh", "fish"))


def run(options: argparse.Namespace) -> int:
    print({"bash": bash, "zsh": zsh, "fish": fish}[options.shell](), end="")
    return 0


def parsers() -> dict[str, tuple[str, argparse.ArgumentParser]]:
    """Every command with its help and its options."""
    from postproc.cli import commands

    found = {}
    for name in commands():
        module = importlib.import_module(f"postproc.commands.{name}")
        parser = argparse.ArgumentParser(prog=name)
        module.arguments(parser)
        found[name] = (module.HELP, parser)
    return found


def bash() -> str:
    """The script for bash."""
    from postproc.cli import DEFAULT

    cases, choices = [], []
    for name, (_, parser) in parsers().items():
        words = [o for action in parser._actions for o in action.option_strings]
        cases.append(f'    {name}) options="{" ".join(words)}";;')
        for action in parser._actions:
            if action.option_strings and action.choices:
                which = "|".join(f"{name}:{o}" for o in action.option_strings)
                values = " ".join(map(str, action.choices))
                choices.append(
                    f'    {which}) COMPREPLY=($(compgen -W "{values}" -- "$word")); return;;'
                )
    every = list(parsers())
    return BASH.format(
        default=DEFAULT, names="|".join(every), cases="\n".join(cases), choices="\n".join(choices),
        commands=" ".join(every), machines=MACHINES,
    )  # fmt: skip


def zsh() -> str:
    """zsh takes bash's."""
    return "autoload -U +X bashcompinit && bashcompinit\n" + bash()


def fish() -> str:
    """The script for fish."""
    lines = ["# fish completion of gcomp; written by gcomp completion fish"]
    for name, (help_, parser) in parsers().items():
        lines.append(f"complete -c gcomp -n __fish_use_subcommand -a {name} -d {_quoted(help_)}")
        seen = _quoted(f"__fish_seen_subcommand_from {name}")
        for action in parser._actions:
            if words := _fish_words(action):
                lines.append(f"complete -c gcomp -n {seen}{words} -d {_quoted(action.help or '')}")
    return "\n".join(lines) + "\n"


def _fish_words(action: argparse.Action) -> str:
    """An option's long names and what it takes, for fish; "": it has no long name."""
    words = "".join(f" -l {o[2:]}" for o in action.option_strings if o.startswith("--"))
    if not words or action.nargs == 0:
        return words
    if action.dest in ("machine", "like"):
        return f"{words} -x -a {_quoted(f'({MACHINES})')}"
    if action.choices:
        return f"{words} -x -a {_quoted(' '.join(map(str, action.choices)))}"
    return f"{words} -r"


def _quoted(text: str) -> str:
    """For fish: within single quotes only \\ and \' are special."""
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"
