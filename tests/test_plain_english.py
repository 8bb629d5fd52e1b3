"""Docs, comments of configurations, messages, help and docstrings are in plain English."""

import ast
import re
from pathlib import Path

import pytest

from tests.conftest import REPOSITORY

PAGES = [
    REPOSITORY / "README.md",
    *(page for page in sorted((REPOSITORY / "docs").rglob("*.md")) if "reference" not in page.parts),
    *sorted((REPOSITORY / "configs").rglob("*.yaml")),
]
SOURCES = sorted((REPOSITORY / "hydrofdi").rglob("*.py"))

INSTEAD = {
    r"hang(s|ing)? on (the|its|a|what|how)\b|hung on": "depends on",
    r"nothing to heed": "no warnings",
    r"told apart": "distinguished",
    r"\bis told\b": "receives, shows",
    r"stands? in for": "is used in place of",
    r"\blet(s|ting)? go\b": "releases",
    r"nobody knows more than": "known only from",
    r"\bwhole numbers?\b(?= [a-z]*\b(from|or|to be)\b)": "integer",
    r"dotted uprights": "dotted vertical lines",
    r"by the clock\b": "by wall time",
    r"\bin health\b": "while healthy",
    r"\bat the most\b": "at most",
    r"sound (machine|actuator|seal|one)s?\b": "healthy",
    r"^Say (how|what|whether|which|why|where)\b": "Show, Explain",
    r"\bis then a result\b|\bno mistake\b": "is recorded, not rejected",
    r"what (the|two|both) [a-z ]*balances? lacks?\b": "residual of the balance",
    r"balances? of volume": "volume balance",
    r"(left|leave it) alone\b": "was not changed",
    r"is no such case\b": "is not an error",
    r"stays? as it was\b": "does not change",
    r"\bstate behind\b": "state after",
    r"something else than\b": "something other than",
    r"(is|was) to be said\b": "is reported",
    r"\b(do|does) not say enough\b": "is not sufficient",
    r"\bbrought into SI\b": "converted to SI",
    r"what it cannot be\b": "an invalid value",
    r"\bpass(ed|es) over\b": "ignored",
    r"\bnumbered on\b": "numbered consecutively",
}
"""Phrase that must not occur → what to write."""


def texts_of(source):
    """Line and text of all strings of a module."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, " ".join(node.value.split())


def found(pattern, places):
    return [place for place, text in places if re.search(pattern, text, re.MULTILINE)]


def paragraphs(page: Path):
    text = re.sub(r"\n[ \t]*#[ \t]", "\n", page.read_text(encoding="utf-8"))
    name = page.relative_to(REPOSITORY)
    return [(name, " ".join(part.split())) for part in re.split(r"\n\s*\n", text)]


@pytest.fixture(scope="module")
def every_text():
    strings = [
        (f"{file.relative_to(REPOSITORY)}:{line}", text)
        for file in SOURCES
        for line, text in texts_of(file.read_text(encoding="utf-8"))
    ]
    return [*strings, *(part for page in PAGES for part in paragraphs(page))]


def test_the_texts_are_found(every_text):
    assert found("Show what 'hydrofdi sweep' would do", every_text), "help of a command"
    assert found("Effective bulk modulus β", every_text), "description of a key"
    assert found("exceed the limit of", every_text), "message"


@pytest.mark.parametrize(("phrase", "instead"), INSTEAD.items())
def test_no_text_has_a_phrase_that_is_not_plain_english(phrase, instead, every_text):
    places = found(phrase, every_text)
    assert not places, f"write {instead!r}: " + ", ".join(map(str, places))
