"""A number of another indicator in a sliding window."""

import numpy as np
import pytest

from hydrofdi.indicators import make_indicators, measure
from indicators.test_catalogue import all_channels


def sliding(**options):
    (made,) = make_indicators({"sliding": options}).values()
    return made


@pytest.mark.parametrize(("of", "output"), [("dwt", "d2"), ("flow_balance", ""), ("ring_down", "frequency")])
def test_each_number_is_that_of_its_window_measured_by_itself(of, output):
    records = all_channels(2)
    indicator = sliding(of=of, output=output, window="1.2 s", interval="0.3 s")
    name, n_window, every = indicator.options.followed.name, 600, 150
    numbers = indicator.trace(records).values[name]
    for place in range(numbers.shape[1]):
        stop = (place + 1) * every
        if stop < n_window:
            assert np.isnan(numbers[:, place]).all()
            continue
        window = measure(records.window(stop - n_window, stop), make_indicators({of: {}}))
        np.testing.assert_array_equal(numbers[:, place], window.values[f"{of}.{name}"])


def test_a_record_has_the_mean_over_its_windows():
    records = all_channels(2)
    indicator = sliding(of="dwt", output="d2", window="1 s", interval="0.5 s", transient="1.5 s")
    found = measure(records, {"it": indicator}).values
    numbers = indicator.trace(records).since(1.5).values["d2"]
    np.testing.assert_allclose(found["it.d2"], numbers.mean(axis=1), rtol=1e-12)
    np.testing.assert_allclose(found["it.d2_spread"], numbers.std(axis=1), rtol=1e-12)


def test_windows_with_a_missing_sample_have_no_number_and_later_ones_have():
    records = all_channels(1)
    samples = records["chamber_1_pressure"].copy()
    samples[0, 900] = np.nan
    records.channels["chamber_1_pressure"] = samples
    numbers = sliding(output="d2", window="1 s", interval="0.1 s").trace(records).values["d2"][0]
    ends = 50 * (np.arange(numbers.size) + 1)
    np.testing.assert_array_equal(np.isnan(numbers), (ends < 500) | ((ends > 900) & (ends <= 1400)))
