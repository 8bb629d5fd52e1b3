"""Generated pages as files."""

from __future__ import annotations

from pathlib import Path


def write_room(folder: Path, pages: dict[str, str]) -> None:
    """Write the pages of a folder that nothing else writes to."""
    wanted = {folder / f"{name}.md": text for name, text in pages.items()}
    for old in set(folder.rglob("*.md")) - set(wanted):
        old.unlink()
    for file, text in wanted.items():
        write_page(file, text)


def write_page(file: Path, text: str) -> None:
    """Write a page, unless it is up to date: Sphinx reads again what was written again."""
    if not file.is_file() or file.read_text(encoding="utf-8") != text:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A table in Markdown."""
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def hidden_toctree(names: list[str]) -> str:
    """The pages below this one, in the navigation alone."""
    return "\n".join(["```{toctree}", ":hidden:", "", *names, "```", ""])
