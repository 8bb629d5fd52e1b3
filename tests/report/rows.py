"""What people read in a table, and contents that are kept; HYDROFDI_WRITE_GOLDEN=1 writes them anew."""

import os
from pathlib import Path
from pprint import pformat


def rows(table):
    return [[text for text, _ in row] for row in table.texts()]


def check_golden(name, content):
    """Compare a text, or the values of a record, with what a file keeps."""
    path = Path(__file__).parent / "golden" / name
    text = content if isinstance(content, str) else pformat(content, width=110, sort_dicts=False) + "\n"
    if os.environ.get("HYDROFDI_WRITE_GOLDEN"):
        path.write_text(text, encoding="utf-8")
    assert text == path.read_text(encoding="utf-8")
