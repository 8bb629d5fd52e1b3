"""Scores as titles in figures."""

from dataclasses import replace

import pytest

from hydrofdi.report.detection.wording import score_title
from tests.report.detection.made_up import P1, P2, U, X, judged


@pytest.mark.parametrize(
    ("name", "indicator", "channels", "title"),
    [
        ("balance_P1_P2_x_u.mean_leakage", "flow_balance", (P1, P2, X, U), "flow_balance, mean leakage"),
        ("balance_P1.leakage", "", (P1,), "balance, leakage"),
        ("my_own.leakage", "flow_balance", (P1, P2, X, U), "my_own, leakage"),
        ("weak_rls.leakage_flow", "weak_rls", (P1, P2, X, U), "weak_rls, leakage flow"),
        ("largest_change(d1 … d5)", "", (P1,), "largest change (d1 … d5)"),
    ],
)
def test_a_title_has_the_users_own_name_but_no_sensors(name, indicator, channels, title):
    judgement = judged().judgements[0]
    scored = replace(judgement.scored, name=name, indicator=indicator, channels=channels)
    assert score_title(replace(judgement, scored=scored)) == title
