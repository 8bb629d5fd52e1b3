"""Arrays and frames as people have them."""

import numpy as np
import pandas
import pytest

import hydrofdi

PRESSURE = 5e6 + 1e4 * np.random.default_rng(1).standard_normal(4000)
D2 = float(hydrofdi.measure(PRESSURE, sampling_frequency="500 Hz")["dwt.d2"][0])
DATES = pandas.date_range("2026-01-31T12:00", periods=PRESSURE.size, freq="2ms")
SECONDS = np.arange(PRESSURE.size) / 500.0


@pytest.mark.parametrize(
    ("frame", "options"),
    [
        (pandas.DataFrame({"time": SECONDS, "chamber_1_pressure": PRESSURE}), {}),
        (pandas.DataFrame({"t": SECONDS, "P1": PRESSURE}), {"unit": {"t": "s", "P1": "Pa"}}),
        (pandas.DataFrame({"P1 [Pa]": PRESSURE}, index=DATES), {}),
        (pandas.DataFrame({"P1 [Pa]": PRESSURE}, index=DATES.tz_localize("Europe/Berlin")), {}),
        (pandas.DataFrame({"time": DATES.astype(str), "P1 [Pa]": PRESSURE}), {}),
        (
            pandas.DataFrame({"Time": np.arange(PRESSURE.size), "P1 [Pa]": PRESSURE}),
            {"sampling_frequency": "500 Hz"},
        ),
    ],
    ids=["full names", "units beside", "dates", "dates with a zone", "texts", "a counter"],
)
def test_time_is_understood_as_people_have_it(frame, options):
    table = hydrofdi.measure(frame, **options)
    assert table["dwt.d2"].tolist() == pytest.approx([D2], rel=1e-6)


def test_records_of_different_length_make_a_list():
    whole = pandas.DataFrame({"P1 [Pa]": PRESSURE}, index=DATES)
    frames = [whole[:2000], whole]
    table = hydrofdi.measure(frames, label=["sound", "worn"], group="monday")
    assert table["record_id"].tolist() == ["0", "1"]
    assert table["label"].tolist() == ["sound", "worn"]
    assert table["group"].tolist() == ["monday", "monday"]
    assert table["dwt.d2"][1] == pytest.approx(D2, rel=1e-6)
