"""Every figure can be read: nothing cut, covered, faint, alike or without a unit."""

import pytest

from hydrofdi.report.figures import draw_all
from tests.report.figures.laws import faults

PAPER = ("sensitivity", "responses", "figure2", "figure3", "figure4", "spectrum", "mode_plane", "phases")
STUDY = ("ranking", "pod", "roc", "det", "false_alarms", "densities")

FIGURES = [
    *(("modes", name) for name in PAPER),
    *(("alone", name) for name in ("sensitivity", "responses")),
    *(("many", name) for name in ("sensitivity", "responses")),
    *(("scenarios", name) for name in ("sensitivity", "responses", "mode_plane", "scenarios")),
    *(("study", name) for name in (*STUDY, "answer", "tornado")),
    *(("delays", name) for name in (*STUDY, "delays")),
]


@pytest.mark.parametrize(("experiment", "name"), FIGURES)
def test_a_figure_keeps_the_laws_of_reading(reports, experiment, name):
    drawn, holes = draw_all(reports[experiment], [name])
    assert not holes
    assert faults(drawn[name]) == []


def test_every_figure_that_is_drawn_is_looked_at(reports):
    for experiment, report in reports.items():
        drawn, _ = draw_all(report, list(report.figures()))
        assert drawn.keys() == {name for other, name in FIGURES if other == experiment}
