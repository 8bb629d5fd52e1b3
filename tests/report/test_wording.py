"""Words of reports."""

import pytest

from hydrofdi.report.wording import capitalized


@pytest.mark.parametrize(("sentence", "written"), [
    ("with P1, dwt.d1 finds leaks", "With P1, dwt.d1 finds leaks"),
    ("ekf_joint.leakage: no threshold", "ekf_joint.leakage: no threshold"),
    ("ekf_joint finds leaks", "ekf_joint finds leaks"),
    ("", ""),
])  # fmt: skip
def test_a_sentence_starts_with_a_capital_but_names_stay_as_they_are(sentence, written):
    assert capitalized(sentence) == written
