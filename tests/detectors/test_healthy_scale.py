"""Healthy median and spread of scores."""

import numpy as np
import pytest

from hydrofdi.detectors.healthy_scale import healthy_scale
from hydrofdi.errors import NotStatedError


def test_a_scale_leaves_out_what_is_missing():
    scale = healthy_scale(np.array([[1.0, 2.0, np.nan], [3.0, 4.0, 5.0]]))
    assert (scale.centre, scale.n) == (3.0, 5)
    np.testing.assert_allclose(scale([3.0, np.nan]), [0.0, np.nan])


@pytest.mark.parametrize("scores", [np.ones(10), np.arange(4.0)], ids=["all equal", "too few"])
def test_no_scale_without_a_spread(scores):
    with pytest.raises(NotStatedError):
        healthy_scale(scores)
