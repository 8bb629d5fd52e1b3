"""Labels of features fit beside their panels."""

import pytest

from hydrofdi.report.figures.responses import _LETTERS, _label


@pytest.mark.parametrize(
    "name",
    [
        "flow_balance.internal_leakage_coefficient [m^3.5/kg^0.5]",
        "balance_P1_P2_x_u.cross_port_leakage [L/min]",
        "pressure_statistics.kurtosis",
    ],
)
def test_a_long_name_is_broken_into_short_lines_and_nothing_is_lost(name):
    lines = _label(name).split("\n")
    assert max(map(len, lines)) <= _LETTERS
    assert "".join(lines).removesuffix("[–]") == name.replace(" ", "")
