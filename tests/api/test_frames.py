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


@pytest.mark.parametrize("name", ["Druck A (bar)", "Druck A"])
def test_a_column_is_named_with_or_without_its_unit(name):
    frame = pandas.DataFrame({"Druck A (bar)": PRESSURE / 1e5})
    table = hydrofdi.measure(frame, channel={name: "P1"}, sampling_frequency="500 Hz")
    assert table["dwt.d2"][0] == pytest.approx(D2)
    same = hydrofdi.measure(frame, channel={name: "P1"}, unit={name: "bar"}, sampling_frequency="500 Hz")
    assert same["dwt.d2"][0] == pytest.approx(D2)
    with pytest.raises(hydrofdi.HydrofdiError, match="the file says bar, the description says Pa"):
        hydrofdi.measure(frame, channel={name: "P1"}, unit={name: "Pa"}, sampling_frequency="500 Hz")


@pytest.mark.parametrize("name", ["timestamp", "datetime", "Zeit", "Zeitstempel"])
def test_dates_are_time_in_a_column_and_in_the_index(name):
    indexed = pandas.DataFrame({"P1 [Pa]": PRESSURE}, index=DATES.rename(name))
    for frame in (indexed, indexed.reset_index(), indexed.reset_index().astype({name: str})):
        assert hydrofdi.measure(frame)["dwt.d2"][0] == pytest.approx(D2, rel=1e-6)


def test_numbers_named_like_dates_are_no_time():
    frame = pandas.DataFrame({"Zeit": np.arange(PRESSURE.size) / 500.0, "P1 [Pa]": PRESSURE})
    with pytest.raises(hydrofdi.HydrofdiError, match="no sampling frequency is given"):
        hydrofdi.measure(frame)
