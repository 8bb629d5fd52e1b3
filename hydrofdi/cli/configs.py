"""``hydrofdi configs``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrofdi.cli.options import Json


def configs(
    name: Annotated[str | None, typer.Argument(help="Configuration to print, or group to list.")] = None,
    json: Json = False,
) -> int:
    """List the ready configurations, or print one to copy.

    Their names work wherever a command takes a configuration: 'hydrofdi sweep table3'. A file of your own
    with the same name takes precedence.
    """
    from hydrofdi.cli.terminal import print_json, write_out
    from hydrofdi.errors import ConfigError
    from hydrofdi.settings.ready import ready_copy, ready_hint, ready_names, ready_summary

    asked = (name or "").removeprefix("configs/").removesuffix(".yaml").rstrip("/")
    listed = [each for each in ready_names() if name is None or each.startswith(f"{asked}/")]
    if listed and (asked not in ready_names() or str(name).endswith("/")):
        summaries = {each: ready_summary(each) for each in listed}
        if json:
            print_json({"configs": [{"name": each, "about": text} for each, text in summaries.items()]})
        else:
            _print_all(summaries)
        return 0
    if asked not in ready_names():
        raise ConfigError(f"{name}: no such ready configuration{ready_hint(Path(asked))}")
    text = ready_copy(asked)
    if json:
        print_json({"name": asked, "about": ready_summary(asked), "text": text})
    else:
        write_out(text)
    return 0


def _print_all(summaries: dict[str, str]) -> None:
    from hydrofdi.cli.tables import print_table
    from hydrofdi.cli.terminal import terminal
    from hydrofdi.report.table import Table

    console = terminal()
    print_table(console, Table.of({"name": [*summaries], "about": [*summaries.values()]}))
    console.print("\nUse a name like a file: 'hydrofdi sweep table3', 'hydrofdi plan delays/smoke'.")
    console.print("'hydrofdi configs NAME' prints one to copy.")
