"""What pip shall install, from pyproject.toml and constraints.txt.

::

    python .ci/requirements.py pip           pip itself, pinned and with hashes
    python .ci/requirements.py runtime test  the dependencies of hydrofdi, its build backend, and of extras

pip takes versions and hashes of the second list from constraints.txt, and checks every file against them
(``--require-hashes``). The pip of Python 3.11 (23.2) cannot do that, so the pinned one is installed first.
"""

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def pinned(name: str) -> str:
    """The entry of one package in constraints.txt, with its hashes."""
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    first = next(index for index, line in enumerate(lines) if line.startswith(f"{name}=="))
    last = next(index for index in range(first, len(lines)) if not lines[index].endswith("\\"))
    return "\n".join(lines[first : last + 1])


def required(groups: list[str]) -> list[str]:
    """The requirements of ``runtime`` and of extras, as pyproject.toml states them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    extras = project["project"]["optional-dependencies"]
    runtime = project["build-system"]["requires"] + project["project"]["dependencies"]
    return [line for group in groups for line in (runtime if group == "runtime" else extras[group])]


if __name__ == "__main__":
    wanted = sys.argv[1:]
    print(pinned("pip") if wanted == ["pip"] else "\n".join(required(wanted)))
