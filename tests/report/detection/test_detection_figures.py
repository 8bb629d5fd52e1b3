"""Figures of a judged study, also of one that carries little."""

import re
from dataclasses import replace

import pytest

from hydrofdi.report.figures import draw_all, draw_figure
from hydrofdi.report.figures.style import figure_bytes
from hydrofdi.report.publication import write_page
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.rules import Rules
from tests.report.detection.made_up import judged, made_up_records, made_up_score, report_of

FIGURES = {"answer", "ranking", "pod", "roc", "det", "false_alarms", "densities"}


def texts(figure):
    found = figure.findobj(lambda artist: hasattr(artist, "get_text") and artist.get_text())
    return " ".join(artist.get_text() for artist in found)


@pytest.fixture(scope="module")
def page(detection, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "page.html"
    write_page(report_of(detection), path)
    return path.read_text(encoding="utf-8")


def test_every_figure_is_drawn_and_stands_in_the_page(detection, page):
    assert set(report_of(detection).figures()) == FIGURES
    assert set(re.findall(r'<figure id="(\w+)" tabindex="0">\s*<svg', page)) == FIGURES


def test_ids_of_the_page_are_unique_and_it_has_no_script(page):
    ids = re.findall(r'\bid="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    assert {*re.findall(r'href="#([^"]+)"', page), *re.findall(r"url\(#([^)]+)\)", page)} <= set(ids)
    assert "<script" not in page


@pytest.mark.parametrize("name", ["ranking", "pod", "det", "false_alarms", "densities"])
def test_the_best_of_each_set_of_sensors_and_the_wavelet_rules_are_shown(detection, name):
    shown = re.sub(r"\s", "", texts(draw_figure(report_of(detection), name)))
    for score in ("flow_balance.leakage_coefficient", "pressure_balance.leakage_flow", "dwt.d2", "dwt.d3"):
        assert score in shown


def test_the_ranking_shows_what_is_found(detection):
    (axis,) = draw_figure(report_of(detection), "ranking").axes
    first = detection.judgements[0].smallest
    drawn = {float(x) for line in axis.lines for x in line.get_xdata()}
    for name in ("q90", "q90_95"):
        assert any(x == pytest.approx(first[name].severity * 6e4) for x in drawn)


def test_densities_of_flows_are_drawn_in_litres_per_minute():
    records = made_up_records()
    score = made_up_score(records, "leak", gain=200.0, unit="m^3/s")
    scaled = replace(score, values=score.values * 1e-3 / 60.0)
    detection = detect(records, [scaled], Rules())
    (axis,) = draw_figure(report_of(detection), "densities").axes
    assert axis.get_xlabel() == "score [L/min]"
    threshold = 6e4 * detection.judgements[0].threshold.high
    assert any(line.get_xdata()[0] == pytest.approx(threshold) for line in axis.lines)


def test_the_figure_of_false_alarms_shows_rates_and_intervals(detection):
    axis = draw_figure(report_of(detection), "false_alarms").axes[0]
    rates = detection.judgements[0].false_alarms.values()
    drawn = {round(float(x), 6) for line in axis.lines for x in line.get_xdata()}
    for rate in rates:
        assert {round(100.0 * end, 6) for end in (rate.low, rate.value, rate.high)} <= drawn


def test_equal_scores_are_not_called_apart():
    detection = judged(scores=equal, n_healthy=120, n_other=20)
    assert "apart" not in texts(draw_figure(report_of(detection), "det"))


def test_scores_that_never_overlap_are_called_apart():
    def easy(records):
        return [made_up_score(records, "easy", gain=1e4)]

    detection = judged(scores=easy, n_healthy=120, n_other=20, severities=(0.1, 1.0))
    assert "do not overlap" in texts(draw_figure(report_of(detection), "det"))


def one_score(records):
    return [made_up_score(records, "constant", gain=0.0, missing=1.0)]


def equal(records):
    score = made_up_score(records, "equal", gain=0.0)
    score.values[:] = 3.0
    return [score]


@pytest.mark.parametrize(
    "chosen",
    [
        {"shifts": (), "confusions": (), "severities": (0.1, 0.3)},
        {"severities": (0.5,), "confusions": ()},
        {"severities": ()},
        {"scores": one_score},
        {"scores": equal},
        {"n_healthy": 10, "n_other": 1},
    ],
    ids=lambda chosen: " ".join(chosen),
)
def test_a_study_that_carries_little_is_drawn_as_far_as_it_goes(chosen, tmp_path):
    report = report_of(judged(**{"n_healthy": 120, "n_other": 20, **chosen}))
    drawn, holes = draw_all(report, sorted(report.figures()))
    assert FIGURES - {"answer"} <= drawn.keys() | holes.keys()
    for figure in drawn.values():
        assert figure_bytes(figure, "png")
    write_page(report, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert page.count('class="hole"') == len(set(report.document().figures) & holes.keys())
    assert "nan" not in re.sub(r"<svg.*?</svg>", "", page, flags=re.DOTALL).lower()
