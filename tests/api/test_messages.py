"""Messages from Python name keywords, the parts of data by their place, and the keys of a section."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest

import hydrofdi


def test_each_of_several_frames_is_named_by_its_place():
    frames = [pd.DataFrame({"P1 [bar]": [50.0, 51.0]}), pd.DataFrame({"torque [N·m]": [1.0, 2.0]})]
    with pytest.raises(hydrofdi.HydrofdiError, match=r"^DataFrame 2: no column is named like a channel"):
        hydrofdi.measure(frames, sampling_frequency="1 kHz")


def test_each_of_several_arrays_is_named_by_its_place():
    arrays = [np.zeros(100), np.zeros((2, 2, 100))]
    with pytest.raises(hydrofdi.HydrofdiError, match=r"^array 2: has 3 dimensions"):
        hydrofdi.measure(arrays, sampling_frequency="1 kHz")


def test_few_records_of_several_frames_are_told_with_each_name():
    frame = pd.DataFrame({"P1 [Pa]": 5e6 + 1e4 * np.random.default_rng(1).standard_normal(1000)})
    with pytest.raises(hydrofdi.HydrofdiError) as refused:
        hydrofdi.train([frame] * 3, output="d2", sampling_frequency="1 kHz", direction="both")
    assert "the DataFrame" not in str(refused.value)


@pytest.mark.parametrize(
    ("stated", "hint"),
    [
        ({"window": "2 s"}, "found '2 s'; its keys are by, duration, every, channel, edge"),
        ({"window": 2}, "found 2; its keys are by, duration, every, channel, edge"),
    ],
)
def test_a_value_for_a_section_is_refused_with_its_keys(stated, hint):
    records = np.random.default_rng(1).standard_normal((4, 1000))
    with pytest.raises(hydrofdi.HydrofdiError, match=re.escape(hint)):
        hydrofdi.train(records, config=stated, sampling_frequency="1 kHz")
