"""A page of every public name of the package, from its docstring."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import hydrofdi
from generators.commands import command_group
from generators.writing import hidden_toctree, write_room

INTRODUCTION = """\
# Python

The public names of `hydrofdi`; all else may change. [From Python](../../python.md) shows them at work.
"""

GROUPS = {
    "Commands": "What the commands of the same names do.",
    "Results": "What these functions return and raise.",
    "Building blocks": "Experiments and indicators by themselves.",
}


def public_names() -> list[str]:
    """Names with a page."""
    return [name for name in hydrofdi.__all__ if not name.startswith("_")]


def write(reference: Path) -> None:
    """Write all pages below ``reference/api``."""
    groups: dict[str, list[str]] = {title: [] for title in GROUPS}
    for name in public_names():
        groups[_group(name)].append(name)
    parts = [f"## {title}\n\n{GROUPS[title]}\n\n{_summaries(names)}" for title, names in groups.items()]
    index = "\n".join([INTRODUCTION, *parts, hidden_toctree(public_names())])
    write_room(reference / "api", {"index": index} | {name: _page(name) for name in public_names()})


def _group(name: str) -> str:
    if inspect.isclass(_object(name)):
        return "Results"
    return "Commands" if name in {*command_group().commands, "results"} else "Building blocks"


def _summaries(names: list[str]) -> str:
    entries = "\n".join(f"   hydrofdi.{name}" for name in names)
    return f"```{{eval-rst}}\n.. autosummary::\n   :nosignatures:\n\n{entries}\n```\n"


def _page(name: str) -> str:
    directive = "autoclass" if inspect.isclass(_object(name)) else "autofunction"
    members = "\n   :members:" if directive == "autoclass" else ""
    return f"# {name}\n\n```{{eval-rst}}\n.. {directive}:: hydrofdi.{name}{members}\n```\n"


def _object(name: str) -> Any:
    return getattr(hydrofdi, name)
