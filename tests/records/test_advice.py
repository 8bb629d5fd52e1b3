"""What the messages advise leads to right numbers, never to a scale that nobody stated."""

import pytest

from hydrofdi.errors import DataError
from tests.records.measuring import P1, USUAL, batches, kinds, one


@pytest.mark.parametrize(
    ("header", "meant"), [("Bar", "'bar'"), ("barg", "'bar'"), ("BAR", "'bar'"), ("mpa", "'MPa' or 'mPa'")]
)
def test_an_unknown_unit_is_answered_by_similar_ones_alone(tmp_path, header, meant):
    usual = USUAL.replace("{column: P1, unit: bar}", "P1")
    with pytest.raises(DataError, match=f"did you mean {meant}") as raised:
        batches(tmp_path, usual, a_csv=f"P1 [{header}]\n1\n2\n")
    assert "unit: Pa" not in str(raised.value)


def test_a_unit_without_similar_ones_gets_no_scale(tmp_path):
    usual = USUAL.replace("{column: P1, unit: bar}", "P1")
    with pytest.raises(DataError, match="unknown unit 'kgf/cm2'; give 'gain'"):
        batches(tmp_path, usual, a_csv="P1 [kgf/cm2]\n1\n2\n")


def test_another_spelling_agrees_with_its_unit_alone(tmp_path):
    batch = one(tmp_path, a_csv="P1 [Bar]\n1\n2\n")
    assert batch[P1].tolist() == [[1e5, 2e5]]
    assert "unknown_unit" not in kinds(batch)
    with pytest.raises(DataError, match="the file says Bar, the description says Pa"):
        batches(tmp_path, USUAL.replace("bar", "Pa"), a_csv="P1 [Bar]\n1\n2\n")


def test_a_scale_that_the_header_may_contradict_is_remarked(tmp_path):
    batch = one(tmp_path, a_csv="P1 [kgf/cm2]\n1\n2\n")
    (text,) = [remark.text for remark in batch.remarks[0] if remark.kind == "unknown_unit"]
    assert "the header says 'kgf/cm2', the description 'bar'" in text
