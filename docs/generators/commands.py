"""A page of every command, from the command line itself."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import typer
import typer.main

from generators.examples import EXAMPLES
from generators.writing import hidden_toctree, table, write_room
from hydrofdi.cli.app import application

INTRODUCTION = """\
# Commands

Each takes `--help`. Mistakes that you can fix are listed one per line; the exit code is then 2. `--json` is
for programs ([keys and exit codes](../../json.md)).
"""

_CODE = re.compile(r"'(hydrofdi [^']*|--[^']*)'|(?<![\w`-])(--[a-z][a-z-]+)|([\w.]+='[^']*')")
_DEFAULT = re.compile(r"\s*\[default: ([^\]]*)\]\.?")
_KEYS = Path(__file__).parents[1] / "json.md"


def write(reference: Path) -> None:
    """Write all pages below ``reference/commands``."""
    commands = command_group().commands
    rows = [(f"[`{name}`]({name}.md)", _summary(command)) for name, command in commands.items()]
    index = [
        INTRODUCTION,
        table(("command", "what it does"), rows),
        "",
        hidden_toctree([f"{name} <{name}>" for name in commands]),
    ]
    pages = {name: _page(name, command) for name, command in commands.items()}
    write_room(reference / "commands", {"index": "\n".join(index)} | pages)


def command_group() -> Any:
    """The command ``hydrofdi`` with its commands."""
    return typer.main.get_command(application())


def _page(name: str, command: Any) -> str:
    context = command.context_class(command, info_name=f"hydrofdi {name}", help_option_names=["-h", "--help"])
    parameters = [parameter for parameter in command.get_params(context) if parameter.name != "help"]
    kinds = {
        kind: [
            parameter.get_help_record(context)
            for parameter in parameters
            if parameter.param_type_name == kind
        ]
        for kind in ("argument", "option")
    }
    usage = command.get_usage(context).removeprefix("Usage: ")
    parts = [f"# hydrofdi {name}", _prose(command.help), f"```text\n{' '.join(usage.split())}\n```"]
    parts += [f"## {kind.title()}s\n\n{_parameters(kind, rows)}" for kind, rows in kinds.items() if rows]
    parts += [f"## Examples\n\n```sh\n{EXAMPLES[name]}```", f"## Exit codes\n\n{_exit_codes()}"]
    return "\n\n".join([*parts, *_keys(name)]) + "\n"


def _summary(command: Any) -> str:
    return _prose(command.help.partition("\n\n")[0])


def _parameters(kind: str, records: list[tuple[str, str]]) -> str:
    rows = [
        (
            f"`{name}`",
            ", ".join(f"`{value}`" for value in _DEFAULT.findall(text)),
            _prose(_DEFAULT.sub("", text)),
        )
        for name, text in records
    ]
    if not any(default for _, default, _ in rows):
        return table((kind, "meaning"), [(name, meaning) for name, _, meaning in rows])
    return table((kind, "default", "meaning"), rows)


def _prose(text: str) -> str:
    """Text of the command line as Markdown: commands and options in it as code."""
    return _CODE.sub(
        lambda found: f"`{found[1] or found[2] or found[3]}`", " ".join(text.split(" "))
    ).replace("<", "\\<")


def _exit_codes() -> str:
    return (
        f"{str(application(()).info.epilog).removeprefix('Exit codes: ')} [More](../../json.md#exit-codes)."
    )


def _keys(name: str) -> list[str]:
    described = f"\n## {name}\n" in _KEYS.read_text(encoding="utf-8")
    return [f"Keys of `--json`: [{name}](../../json.md#{name})."] if described else []
