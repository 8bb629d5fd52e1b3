"""The headings of the troubleshooting page are what the program says."""

import ast
import re

import pytest

from hydrofdi.quality.doubts import DOUBTS, REMEDIES
from tests.documentation.pages import ROOT

PAGE = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
HEADINGS = re.findall(r"^### (.*)$", PAGE, re.MULTILINE)
WORDS = {word for heading in HEADINGS for word in re.findall(r"`([a-z_]+)`", heading)}


@pytest.fixture(scope="module")
def said():
    """All texts in the source, those of f-strings with … for each value."""
    texts = []
    for file in (ROOT / "hydrofdi").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.JoinedStr):
                texts.append("".join(getattr(part, "value", "…") if isinstance(part, ast.Constant) else "…"
                                     for part in node.values))  # fmt: skip
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                texts.append(node.value.replace("{}", "…"))
    return texts


def test_every_verdict_and_every_failure_has_a_heading():
    assert {*DOUBTS, *REMEDIES} - {"error"} <= WORDS
