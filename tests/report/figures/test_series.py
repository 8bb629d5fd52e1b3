"""Series of a figure differ in colour, in line and in marker."""

from hydrofdi.report.figures.style import COLORS, LINES, MARKERS, series


def test_eight_series_differ_in_colour_in_line_and_in_marker():
    assert [len({str(each) for each in looks}) for looks in (COLORS, LINES, MARKERS)] == [8, 8, 8]
    many = [series(place, 12) for place in range(12)]
    assert len({(str(each["color"]), str(each["linestyle"])) for each in many}) == 12
