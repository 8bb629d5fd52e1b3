"""`Evaluation.plot`: scores of labelled records in memory."""

from dataclasses import replace

import numpy as np
import pytest

import hydrofdi
from hydrofdi.errors import ReportError


def evaluation(n_healthy):
    random = np.random.default_rng(0)
    records = 5e6 + np.vstack([
        1e4 * random.standard_normal((n_healthy, 500)), 1.5e4 * random.standard_normal((10, 500))
    ])  # fmt: skip
    label = ["sound"] * n_healthy + ["worn"] * 10
    return hydrofdi.evaluate(
        records, "dwt", label=label, healthy="sound", false_alarm_rate="5 %", sampling_frequency="1 kHz"
    )


def texts_of(axis):
    return [text.get_text() for text in (axis.title, axis._left_title)]


def texts(figure):
    return [text for axis in figure.axes for text in texts_of(axis)]


@pytest.mark.parametrize("n_healthy", [100, 4], ids=["with limits", "too few for limits"])
def test_the_scores_are_drawn_with_limits_if_there_are_any(n_healthy):
    found = evaluation(n_healthy)
    has_limits = any(each.threshold is not None for each in found.detection.judgements)
    assert has_limits == (n_healthy == 100)
    figure = found.plot()
    assert any(text.startswith("dwt.d1") for text in texts(figure))
    rows = [text.get_text() for text in figure.axes[0].get_yticklabels()]
    assert rows == ["healthy (fit)", "healthy", "worn"]
    assert any(axis.lines for axis in figure.axes) == has_limits
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_another_figure_has_a_name_and_a_wrong_name_is_refused():
    found = evaluation(100)
    assert found.plot("roc").axes
    with pytest.raises(ReportError, match=r"no figure .density.*densities"):
        found.plot("density")


def far_apart():
    """The rate needs 99 healthy records to set limits, and 80 set them: only two scores have limits."""
    random = np.random.default_rng(0)
    records = 8e6 + np.vstack([
        1e4 * random.standard_normal((160, 1000)), 2e4 * random.standard_normal((40, 1000))
    ])  # fmt: skip
    return hydrofdi.evaluate(
        records, "dwt", label=["a"] * 160 + ["b"] * 40, healthy="a", false_alarm_rate="2 %",
        sampling_frequency="500 Hz",
    )  # fmt: skip


def test_the_best_scores_are_drawn_first_and_whole():
    found = far_apart()
    figure = found.plot()
    assert next(text for text in texts(figure) if text).startswith(found.best)
    for axis in figure.axes:
        name = next(text for text in texts_of(axis) if text).split("\n")[0]
        judgement = next(each for each in found.detection.judgements if each.scored.name == name)
        shown = axis.get_xlim()[1] / (1e-6 if "MPa" in axis.get_xlabel() else 1e-3)
        assert judgement.scored.values.max() < shown
        assert not any("→" in text.get_text() for text in axis.texts)


def test_an_evaluation_in_which_nothing_is_measured_has_empty_tables():
    found = far_apart()
    empty = replace(found, detection=replace(found.detection, judgements=()), healthy_pairs={})
    assert (len(empty.table), len(empty.pairs), empty.best) == (0, 0, "")
