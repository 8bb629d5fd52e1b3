"""A page of every ready configuration: its question, its commands, its text."""

from __future__ import annotations

import os
import re
from itertools import groupby
from pathlib import Path

from generators.writing import hidden_toctree, table, write_room
from hydrofdi.settings.files import ready_folder, ready_names, ready_summary

INTRODUCTION = """\
# Ready configurations

They are in the package. Their names stand for them wherever a file is asked for: `hydrofdi sweep table3`,
`hydrofdi plan delays/smoke`. `hydrofdi configs` lists them, and `hydrofdi configs NAME` prints one to copy.
The page of each shows the file, which is in the folder `configs` of the repository.
"""

GROUPS = {
    "": "Experiments and studies",
    "delays": "Delays",
    "detectability": "Studies of detection",
    "detectors": "Detectors that know a model",
    "machines": "Machines",
    "measured": "Measured records",
    "monitoring": "Monitoring",
    "motions": "Motions",
    "populations": "Populations",
    "templates": "Templates of hydrofdi init",
}

_COMMAND = re.compile(r"^# {2,}(hydrofdi .*)$", re.MULTILINE)
_READY = re.compile(r"configs/([\w/-]+)\.yaml")


def write(reference: Path) -> None:
    """Write all pages below ``reference/configurations``."""
    names = ready_names()
    pages = {"index": "\n".join([INTRODUCTION, *map(_group, _grouped(names)), hidden_toctree(names)])}
    home = reference / "configurations"
    write_room(home, pages | {name: _page(name, home / f"{name}.md") for name in names})


def _grouped(names: list[str]) -> list[tuple[str, list[str]]]:
    return [(group, list(same)) for group, same in groupby(names, key=lambda name: name.rpartition("/")[0])]


def _group(grouped: tuple[str, list[str]]) -> str:
    group, names = grouped
    rows = [
        (f"[`{name}`]({name}.md)", ready_summary(name), "<br>".join(f"`{line}`" for line in _commands(name)))
        for name in names
    ]
    return f"## {GROUPS[group]}\n\n{table(('name', 'question', 'commands'), rows)}\n"


def _page(name: str, page: Path) -> str:
    commands = "\n".join(_commands(name))
    shown = f"```sh\n{commands}\n```\n" if commands else ""
    file = os.path.relpath(_file(name), page.parent)
    return (
        f"# {name}\n\n{ready_summary(name)}\n\n{shown}\n```{{literalinclude}} {file}\n:language: yaml\n```\n"
    )


def _commands(name: str) -> list[str]:
    """The commands of its first comment, with the names of ready configurations in place of their files."""
    lines = _COMMAND.findall(_file(name).read_text(encoding="utf-8"))
    return [command for line in lines for command in _READY.sub(r"\1", line).split(" && ")]


def _file(name: str) -> Path:
    return ready_folder() / f"{name}.yaml"
