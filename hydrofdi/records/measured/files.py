"""The files that match patterns."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterable
from pathlib import Path, PurePath

_DIGITS = re.compile(r"(\d+)")


def matching_files(folder: Path, pattern: str) -> list[Path]:
    """Files that match a pattern, in natural order: run 2 before run 10.

    Leading parts of the pattern that exist literally are taken literally, including brackets and stars.

    Parameters
    ----------
    folder : path
        Base of relative patterns.
    pattern : str
    """
    parts = PurePath(pattern).parts
    literal = 0
    while literal < len(parts) and os.path.lexists(folder.joinpath(*parts[: literal + 1])):
        literal += 1
    start = folder.joinpath(*parts[:literal])
    if literal == len(parts):
        return [start] if start.is_file() else []
    found = glob.glob(os.path.join(*parts[literal:]), root_dir=start, recursive=True)
    return in_natural_order(start / name for name in found if (start / name).is_file())


def in_natural_order(paths: Iterable[Path]) -> list[Path]:
    """Paths in natural order: numbers in them are sorted by value."""
    return sorted(paths, key=lambda path: _natural(path.as_posix()))


def place_of(path: Path, folder: Path) -> str:
    """The path relative to a folder, with forward slashes: the name of a record."""
    return Path(os.path.relpath(path, folder)).as_posix()


def _natural(text: str) -> tuple[list[tuple[str, int]], str]:
    pieces = _DIGITS.split(text)
    numbers = [int(piece) for piece in pieces[1::2]] + [0]
    return list(zip(pieces[::2], numbers, strict=True)), text
