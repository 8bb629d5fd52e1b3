"""The words of a verdict stand in one place; what is written by hand elsewhere follows them."""

from dataclasses import fields

import pytest

from hydrofdi.quality.doubts import DOUBTS, doubts_of
from hydrofdi.quality.run_quality import RunQuality
from hydrofdi.store.layout import names
from tests.conftest import REPOSITORY


@pytest.mark.parametrize("word", DOUBTS)
def test_the_number_behind_a_doubt_is_computed_and_stored(word):
    assert DOUBTS[word].number in {field.name for field in fields(RunQuality)}
    assert DOUBTS[word].number in {variable.name for variable in names.COMPUTED}


@pytest.mark.parametrize("word", DOUBTS)
def test_the_documentation_names_each_doubt_and_its_mark(word):
    assert f"`{word}`" in (REPOSITORY / "docs" / "physics.md").read_text(encoding="utf-8")
    report = (REPOSITORY / "docs" / "report.md").read_text(encoding="utf-8")
    assert f"{DOUBTS[word].mark} {word.replace('_', ' ')}" in report


def test_marks_differ_and_meanings_have_a_place_for_their_number():
    assert len({doubt.mark for doubt in DOUBTS.values()}) == len(DOUBTS)
    assert all("1.5 %" in doubt.meaning.format("1.5") for doubt in DOUBTS.values())


def test_a_verdict_is_read_back_and_a_failure_is_no_doubt():
    words = ["above_supply", "still"]
    assert [doubt.word for doubt in doubts_of(", ".join(words))] == words
    assert doubts_of("ok") == doubts_of("diverged") == doubts_of("") == ()
