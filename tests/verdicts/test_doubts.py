"""The words of a verdict stand in one place; what is written by hand elsewhere follows them."""

import pytest

from hydrofdi.quality.doubts import DOUBTS, doubts_of
from hydrofdi.store.layout import names


@pytest.mark.parametrize("word", DOUBTS)
def test_the_number_behind_a_doubt_is_computed_and_stored(word):
    assert DOUBTS[word].number in {variable.name for variable in names.COMPUTED}


def test_a_verdict_is_read_back_and_a_failure_is_no_doubt():
    words = ["above_supply", "still"]
    assert [doubt.word for doubt in doubts_of(", ".join(words))] == words
    assert doubts_of("ok") == doubts_of("diverged") == doubts_of("") == ()
