"""The figures of the gallery: drawn by the very commands that its page shows."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from docutils.nodes import make_id
from sphinx.errors import ExtensionError

import hydrofdi
from hydrofdi.settings.files import ready_folder

if TYPE_CHECKING:
    from sphinx.application import Sphinx

_FIGURE = re.compile(r"^###? ([^\n]+)\n(?:(?!^#).)*?^```\{figure\} (\S+)", re.DOTALL | re.MULTILINE)
_CARD = """:::{{grid-item-card}} {title}
:img-top: {picture}
:img-alt:
:link: "#{anchor}"
:link-type: url
:::
"""
_COMMANDS = re.compile(r"^```sh\n(.*?)^```", re.DOTALL | re.MULTILINE)


def show_thumbnails(app: Sphinx, name: str, content: list[str]) -> None:
    """Show the first figure of each section above the first section: Sphinx passes each source."""
    if name == "gallery":
        cards = [
            _CARD.format(title=title, picture=picture, anchor=make_id(title))
            for title, picture in _FIGURE.findall(content[0])
        ]
        grid = "\n".join(
            ["::::{grid} 2 3 4 5", ":class-container: thumbnails", ":gutter: 2", "", *cards, "::::"]
        )
        content[0] = content[0].replace("\n## ", f"\n{grid}\n\n## ", 1)


def draw(docs: Path) -> None:
    """Run the commands of ``gallery.md`` in ``docs/_gallery``, unless they and the program are as they were.

    Raises
    ------
    ExtensionError
        A command fails; the message is its own.
    """
    script = "\n".join(_COMMANDS.findall((docs / "gallery.md").read_text(encoding="utf-8")))
    folder = docs / "_gallery"
    drawn, wanted = folder / "drawn.txt", _digest(script)
    if drawn.is_file() and drawn.read_text(encoding="utf-8") == wanted:
        return
    folder.mkdir(exist_ok=True)
    places = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    done = subprocess.run(
        ["bash", "-eu", "-c", script],
        cwd=folder, env=os.environ | {"PATH": places}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode != 0:
        raise ExtensionError(f"gallery.md: a command failed: {done.stderr.strip()[-500:]}")
    drawn.write_text(wanted, encoding="utf-8")


def _digest(script: str) -> str:
    """What the figures depend on: the commands, the program, the ready configurations."""
    package = Path(hydrofdi.__file__).parent
    files = [*sorted(package.rglob("*.py")), *sorted(ready_folder().rglob("*.yaml"))]
    digest = hashlib.sha256(script.encode())
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()
