"""What people read in a table, and texts that are kept; HYDROFDI_WRITE_GOLDEN=1 writes them anew."""

import os
from pathlib import Path


def rows(table):
    return [[text for text, _ in row] for row in table.texts()]


def check_golden(name, text):
    path = Path(__file__).parent / "golden" / name
    if os.environ.get("HYDROFDI_WRITE_GOLDEN"):
        path.write_text(text, encoding="utf-8")
    assert text == path.read_text(encoding="utf-8")
