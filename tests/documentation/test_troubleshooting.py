"""The headings of the troubleshooting page are what the program says."""

import ast
import re

import pytest

from hydrofdi.quality.doubts import DOUBTS
from hydrofdi.quality.failures import FAILURES
from tests.commands import run
from tests.documentation.pages import ROOT

PAGE = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
HEADINGS = re.findall(r"^### (.*)$", PAGE, re.MULTILINE)
QUOTED = [text for heading in HEADINGS for text in re.findall(r'"([^"]+)"', heading)]
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


@pytest.mark.parametrize("sentence", QUOTED)
def test_a_quoted_sentence_is_one_of_the_program(sentence, said):
    assert any(sentence in text for text in said)


def test_every_verdict_and_every_failure_has_a_heading():
    assert {*DOUBTS, *FAILURES} - {"error"} <= WORDS


def test_an_unsettled_run_is_helped_by_a_longer_record(tmp_path):
    fast = ["--set", "fluid.bulk_modulus=800 MPa", "--set", "friction.viscous=250 N·s/m", "--json"]
    short = run("simulate", "--set", "record.duration=4 s", *fast, cwd=tmp_path, check=0)
    assert '"verdict": "unsettled"' in short.stdout
    long = run("simulate", "--set", "record.duration=20 s", *fast, cwd=tmp_path, check=0)
    assert '"verdict": "ok"' in long.stdout
