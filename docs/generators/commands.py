"""A page of every command, from the command line itself."""

from __future__ import annotations

from pathlib import Path

import typer.main

from generators.writing import hidden_toctree, table, write_room
from hydrofdi.cli.app import app


def write(reference: Path) -> None:
    """Write all pages below ``reference/commands``."""
    group = typer.main.get_command(app)
    commands = group.commands
    rows = [
        (f"[`hydrofdi {name}`]({name}.md)", command.help.partition("\n")[0])
        for name, command in commands.items()
    ]
    index = f"# Commands\n\n{table(('command', 'what it does'), rows)}\n\n{hidden_toctree(list(commands))}"
    pages = {name: f"# hydrofdi {name}\n\n{command.help}\n" for name, command in commands.items()}
    write_room(reference / "commands", {"index": index} | pages)
