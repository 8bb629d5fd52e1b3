import numpy as np
import pytest
import pywt

from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel, RecordBatch
from indicators.laws import assert_batch_has_no_effect, ringing


def records(samples, **more):
    samples = np.atleast_2d(samples)
    ids = tuple(str(row) for row in range(len(samples)))
    return RecordBatch({Channel.CHAMBER_1_PRESSURE: samples}, 500.0, ids, **more)


def test_details_and_approximations_are_those_of_pywavelets():
    signal = np.random.default_rng(1).normal(size=2000)
    values = measure(records(signal), make_indicators(["dwt"])).values
    approximation, *details = pywt.wavedec(signal, "db8", level=5)
    for level, coefficients in zip(range(5, 0, -1), details, strict=True):
        np.testing.assert_allclose(values[f"dwt.d{level}"], np.sqrt(np.mean(coefficients**2)), rtol=1e-12)
    np.testing.assert_allclose(values["dwt.a5"], np.sqrt(np.mean(approximation**2)), rtol=1e-12)


def test_a_phase_is_the_record_from_its_sample_on():
    signal = np.random.default_rng(2).normal(size=(2, 700))
    whole = measure(records(signal), make_indicators({"dwt": {"phase": "all", "levels": 3}})).values
    assert whole["dwt.d2_phases"].shape == (2, 8)
    for phase in range(8):
        part = measure(records(signal), make_indicators({"dwt": {"phase": phase, "levels": 3}})).values
        np.testing.assert_array_equal(whole["dwt.d2_phases"][:, phase], part["dwt.d2"])


def test_another_unit_scales_the_numbers():
    signal = np.random.default_rng(3).normal(size=500)
    one, other = (
        measure(records(k * signal), make_indicators({"dwt": {"levels": 2}})).values for k in (1, 4)
    )
    for name in one:
        np.testing.assert_array_equal(4 * one[name], other[name])


@pytest.mark.parametrize("n_time", [1, 20, 400])
def test_a_record_that_is_too_short_is_not_measured_and_says_so(n_time):
    measures = measure(records(np.ones(n_time)), make_indicators(["dwt"]))
    assert np.isnan(measures.values["dwt.d1"]).all()
    assert f"{n_time} samples are too few for level 5 of db8: it needs 480" in measures.obstacles["dwt"][0]


@pytest.mark.parametrize("phase", [0, "all"])
def test_neither_the_batch_nor_its_layout_changes_a_bit(phase):
    assert_batch_has_no_effect("dwt", ringing(4, 5, 1501), phase=phase)
