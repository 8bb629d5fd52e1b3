"""Files that are named after a figure which a report does not have."""

import pytest

from hydrofdi.errors import ReportError
from hydrofdi.report.figures import write_figure
from hydrofdi.report.figures.detection.marks import sensor_marks
from tests.report.detection.made_up import judged, report_of


@pytest.mark.parametrize("name", ["tornado", "figure2", "rok"])
def test_a_figure_that_a_study_does_not_have_is_refused_with_those_it_has(tmp_path, name):
    with pytest.raises(ReportError, match="ranking, pod"):
        write_figure(report_of(judged()), tmp_path / f"{name}.svg")
    assert not list(tmp_path.iterdir())


def test_a_set_of_sensors_has_one_colour_in_all_figures():
    detection = judged()
    whole = sensor_marks(detection, detection.judgements)
    for few in (detection.judgements[:2], detection.judgements[-2:]):
        assert sensor_marks(detection, few).items() <= whole.items()
