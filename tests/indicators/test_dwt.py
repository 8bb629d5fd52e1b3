import numpy as np
import pywt

from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel, RecordBatch


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
