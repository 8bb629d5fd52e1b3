"""`Evaluation.plot`: scores of labelled records in memory."""

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


def texts(figure):
    return [text.get_text() for axis in figure.axes for text in (axis.title, axis._left_title)]


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
