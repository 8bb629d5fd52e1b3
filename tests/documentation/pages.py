"""Pages that a reader follows: their blocks are run in order, in one folder, as they stand.

``sh`` and ``python`` blocks run, unless ``<!-- not run -->`` stands before them. A ``text`` block after one
is what it prints: its lines in this order; ``…`` stands for whatever comes between, in a line as on a line of
its own. ``<!-- file: NAME -->`` makes the next block a file, ``<!-- edit: NAME -->`` puts its lines in place
of those of a file with the same key, and ``<!-- exit: N -->`` says which exit code the next block ends with.
"""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent.parent

BLOCK = re.compile(
    r"(?:^<!-- (?P<word>[a-z ]+?)(?:: (?P<value>[^\n]*?))? -->\n+)?"
    r"^```(?P<language>[a-z]*)\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)


class Block(NamedTuple):
    """A fenced block, and the comment right before it."""

    language: str
    text: str
    word: str
    value: str


def blocks(page: Path) -> list[Block]:
    """All fenced blocks of a page, in their order."""
    found = BLOCK.finditer(page.read_text(encoding="utf-8"))
    return [Block(each["language"], each["text"], each["word"] or "", each["value"] or "") for each in found]


def follow(page: Path, folder: Path) -> None:
    """Do in a folder what a page says, and compare what it shows."""
    printed = ""
    for block in blocks(page):
        if block.word == "file":
            (folder / block.value).write_text(block.text, encoding="utf-8")
        elif block.word == "edit":
            edit(folder / block.value, block.text)
        elif block.word == "not run":
            printed = ""
        elif block.language in PROGRAMS:
            printed = run(block, folder)
        elif block.language == "text":
            compare(block.text, printed, page.name)


PROGRAMS = {"sh": ["bash", "-eu", "-o", "pipefail", "-c"], "python": [sys.executable, "-c"]}


def run(block: Block, folder: Path) -> str:
    """What a block prints, on both outputs, where its commands are installed and nothing else is."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    environment |= {"PATH": path, "COLUMNS": "80", "MPLBACKEND": "agg"}
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "encoding": "utf-8", "timeout": 900.0}
    done = subprocess.run([*PROGRAMS[block.language], block.text], cwd=folder, env=environment, **options)
    expected = int(block.value) if block.word == "exit" else 0
    assert done.returncode == expected, f"exit {done.returncode} of\n{block.text}\n{done.stdout}"
    return done.stdout


def edit(file: Path, lines: str) -> None:
    """Put each line in place of the one of a file with the same key and indent."""
    text = file.read_text(encoding="utf-8")
    for line in lines.splitlines():
        key = line.partition(":")[0]
        present = re.findall(rf"^{re.escape(key)}:.*$", text, re.MULTILINE)
        assert len(present) == 1, f"{file.name} has {len(present)} lines with {key!r}"
        text = text.replace(f"{present[0]}\n", f"{line}\n")
    file.write_text(text, encoding="utf-8")


def compare(shown: str, printed: str, page: str) -> None:
    """Find the lines that a page shows among those that were printed, in their order.

    A page may fold long lines, as a terminal does.
    """
    said = "".join(f"{' '.join(line.split())}\n" for line in printed.splitlines() if line.strip())
    pattern = ""
    for line in filter(None, (" ".join(line.split()) for line in shown.splitlines())):
        words = (r"[^\n]*".join(map(re.escape, word.split("…"))) for word in line.split())
        pattern += r"(?:[^\n]*\n)*" if line == "…" else r"\ ".join(words) + r"[ \n]"
        assert re.match(pattern, said), (
            f"{page} shows\n{line}\nwhich is not printed there (any more):\n{printed}"
        )
    assert re.fullmatch(pattern, said), f"{page} ends without … before the end of\n{printed}"
