"""Figure 2: signals of the healthy and the leaky actuator."""

from hydrofdi.api.stored import read_results
from hydrofdi.papers.maddahi2015.report import StudyReport
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.figures import draw_figure
from tests.conftest import SMALL, sweep_in


def test_figure_2_shows_the_reference_in_closed_loop_alone(small_sweep, tmp_path):
    text = SMALL.replace("sweep:", "control: {law: pi}\nsweep:")
    closed = Study(read_results(sweep_in(tmp_path, text).directory))
    for analysis, n_line in ((Study(read_results(small_sweep.directory)), 1), (closed, 2)):
        axes = draw_figure(StudyReport(analysis), "figure2").axes
        assert [len(axis.lines) for axis in axes[2:4]] == [n_line] * 2
        assert all(len(axis.lines) == 1 for axis in (*axes[:2], *axes[4:]))
