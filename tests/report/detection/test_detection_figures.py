"""Figures of a judged study, also of one that carries little."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.detectors.rules import Rules
from hydrofdi.report.figures import draw_figure
from hydrofdi.report.page import write_page
from hydrofdi.studies.detecting import detect
from tests.report.detection.made_up import judged, made_up_records, made_up_score, report_of

FIGURES = {"ranking", "pod", "roc", "false_alarms", "densities"}


def places(axis):
    """Where lines have points."""
    return [float(x) for line in axis.lines for x in line.get_xdata()]


@pytest.mark.parametrize("name", ["ranking", "answer"])
def test_the_best_score_has_its_estimate_and_its_bound(detection, name):
    (axis,) = draw_figure(report_of(detection), name).axes
    first = detection.judgements[0].smallest
    for each in ("q90", "q90_95"):
        assert any(x == pytest.approx(first[each].severity * 6e4) for x in places(axis))


def test_densities_have_every_population_and_flows_in_litres_per_minute():
    records = made_up_records(severities=(0.001, 1.0, 100.0))
    score = made_up_score(records, "leak", gain=200.0, unit="m^3/s")
    detection = detect(records, [replace(score, values=score.values * 1e-3 / 60.0)], Rules())
    (axis,) = draw_figure(report_of(detection), "densities").axes
    assert len(axis.patches) == 2 * len(records.populations)
    assert axis.get_xlabel() == "score [L/min]"
    assert any(x == pytest.approx(6e4 * detection.judgements[0].threshold.high) for x in places(axis))


def test_the_figure_of_false_alarms_shows_rates_and_intervals(detection):
    axis = draw_figure(report_of(detection), "false_alarms").axes[0]
    drawn = {round(x, 6) for x in places(axis)}
    for rate in detection.judgements[0].false_alarms.values():
        assert {round(100.0 * end, 6) for end in (rate.low, rate.value, rate.high)} <= drawn


def missing(records):
    return [made_up_score(records, "constant", gain=0.0, missing=1.0)]


def equal(records):
    score = made_up_score(records, "equal", gain=0.0)
    return [replace(score, values=np.full_like(score.values, 3.0))]


@pytest.mark.parametrize(
    "chosen",
    [
        {"severities": (0.5,), "shifts": (), "confusions": ()},
        {"severities": ()},
        {"scores": missing},
        {"scores": equal},
        {"n_healthy": 10, "n_other": 1},
    ],
    ids=lambda chosen: " ".join(chosen),
)
def test_a_study_that_carries_little_is_drawn_as_far_as_it_goes(chosen, tmp_path):
    report = report_of(judged(**{"n_healthy": 120, "n_other": 20, **chosen}))
    assert report.figures().keys() - {"answer"} == FIGURES
    write_page(report, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    drawn = re.findall(r'<figure id="(\w+)" tabindex="0">\s*<svg', page)
    assert len(drawn) + page.count('class="hole"') == len(set(report.document().figures))
    assert "nan" not in re.sub(r"<svg.*?</svg>", "", page, flags=re.DOTALL).lower()


def test_the_drawn_curve_reaches_ninety_percent_where_it_is_stated():
    """It is not drawn where a severity comes from the levels."""
    detection = judged(n_healthy=200, severities=(0.05, 0.1, 0.2, 0.5, 1.0))
    by_name, n_seen = {each.name: each for each in detection.judgements}, 0
    for axis in draw_figure(report_of(detection), "pod").axes:
        title = "".join(axis.get_title(loc="left").split())
        stated = next(by_name[name] for name in by_name if name in title).smallest.get("q90")
        curves = [line for line in axis.lines if len(line.get_xdata()) > 10]
        if stated is None or stated.source == "levels":
            assert not curves
        elif stated.place == "within":
            at = np.interp(stated.value * 6e4, curves[0].get_xdata(), curves[0].get_ydata())
            assert at == pytest.approx(100.0 * Rules().probability, abs=1.0)
            n_seen += 1
    assert n_seen
