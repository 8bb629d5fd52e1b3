import pytest

from hydrofdi.papers.maddahi2015.tables import deviations
from hydrofdi.report.runs import run_table


def deviations_of(data):
    return deviations(run_table(data), data.experiment.reference)


def test_computed_published_and_deviation_stand_side_by_side(made_up):
    d2, d1, absent = deviations_of(made_up)
    assert (d2["computed"], d2["deviation"], d2["agrees"]) == (pytest.approx(10.0), pytest.approx(0.0), True)
    assert d1["agrees"] is None, "the run of this cell failed"
    assert absent["agrees"] is None, "there is no such run"


def test_a_deviation_beyond_the_tolerance_is_reported(made_up, break_cell):
    found = deviations_of(break_cell(made_up, 2, 1, 181_100.0))
    assert found[0]["deviation"] == pytest.approx(-0.55)
    assert found[0]["agrees"] is False
    assert deviations_of(break_cell(made_up, 2, 1, 180_900.0))[0]["agrees"] is True
