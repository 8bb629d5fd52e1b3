"""`hydrofdi.measure`: the same numbers from whatever holds the samples, and what is refused."""

import numpy as np
import pandas
import pytest
import xarray

import hydrofdi
from tests.commands import run_json

RATE = 500.0


@pytest.fixture(scope="module")
def signals():
    leaking = hydrofdi.simulate(internal_flow="0.2 L/min", duration="4 s").to_xarray()
    return leaking[["chamber_1_pressure", "chamber_2_pressure", "input_voltage", "piston_velocity"]]


@pytest.fixture(scope="module")
def pressure(signals):
    return signals.chamber_1_pressure.to_numpy()


@pytest.fixture(scope="module")
def expected(signals, pressure, tmp_path_factory):
    """d2 by the command."""
    file = tmp_path_factory.mktemp("rig") / "rig.csv"
    rows = zip(signals.time.to_numpy().tolist(), pressure.tolist(), strict=True)
    file.write_text("time [s],P1 [Pa]\n" + "".join(f"{time!r},{value!r}\n" for time, value in rows))
    (record,) = run_json("measure", file)["records"]
    return file, record["values"]["dwt.d2"]


def holders(signals):
    bar = signals.chamber_1_pressure.to_numpy() / 1e5
    time = signals.time.to_numpy()
    frame = pandas.DataFrame({"time [s]": time, "P1 [bar]": bar, "note": ["x"] * len(bar)})
    rate = {"sampling_frequency": "500 Hz"}
    return {
        "array": (bar * 1e5, rate),
        "list": ((bar * 1e5).tolist(), {"sampling_frequency": RATE}),
        "array in bar": (bar, {"unit": "bar", **rate}),
        "mapping": ({"P1 [bar]": bar, "time": time}, {}),
        "frame": (frame, {}),
        "frame with index": (frame.set_index("time [s]"), {}),
        "series": (pandas.Series(bar, name="pA"), {"unit": "bar", **rate}),
        "clock": (
            pandas.DataFrame(
                {"P1 [bar]": bar}, index=pandas.Timestamp("2026-01-01") + pandas.to_timedelta(time, "s")
            ),
            {},
        ),
        "named column": (
            frame.rename(columns={"P1 [bar]": "A"}),
            {"channel": {"A": "P1"}, "unit": {"A": "bar"}},
        ),
        "dataset": (signals, {}),
        "data array": (signals.chamber_1_pressure, {}),
        "one of several": ({"P1": bar * 1e5, "P2": bar}, {"channel": "P1", **rate}),
    }


@pytest.mark.parametrize(
    "name", holders(xarray.Dataset({"chamber_1_pressure": ("time", [0.0]), "time": [0.0]}))
)
def test_whatever_holds_the_samples_gives_the_numbers_of_the_command(name, signals, expected):
    data, options = holders(signals)[name]
    table = hydrofdi.measure(data, **options)
    assert len(table) == 1
    np.testing.assert_allclose(table["dwt.d2"], [expected[1]], rtol=1e-9)
    assert table["reasons"].tolist() == [""]


def test_a_file_gives_the_bits_of_the_command(expected):
    file, number = expected
    for path in (file, str(file), [file]):
        table = hydrofdi.measure(path, ["dwt"])
        assert table["dwt.d2"][0] == number
        assert table["record_id"][0] == "rig.csv"


def test_records_side_by_side_are_rows(pressure):
    table = hydrofdi.measure(np.stack([pressure, 2.0 * pressure]), sampling_frequency=RATE)
    np.testing.assert_allclose(table["dwt.d1"][1], 2.0 * table["dwt.d1"][0])
    assert table["record_id"].tolist() == ["0", "1"]


def test_records_of_a_dataset_keep_their_names_and_share_what_has_no_record(signals):
    both = xarray.concat(
        [signals.chamber_1_pressure] * 2, dim=xarray.DataArray(["new", "old"], dims="unit", name="unit")
    )
    data = signals.drop_vars("chamber_1_pressure").assign(chamber_1_pressure=both)
    table = hydrofdi.measure(data, "dwt,cross_correlation")
    assert table["record_id"].tolist() == ["new", "old"]
    assert table["dwt.d2"][0] == table["dwt.d2"][1]


def test_a_table_turns_into_what_people_use(pressure):
    table = hydrofdi.measure(pressure, {"dwt": {}, "volterra": {}}, sampling_frequency=RATE)
    data = table.to_xarray()
    assert data["dwt.d2"].dims == ("record",)
    assert data["dwt.d2"].attrs["units"] == "Pa"
    assert data["volterra.coefficients"].dims == ("record", "volterra.term")
    assert table.to_dict()["dwt.d2"] == table["dwt.d2"].tolist()
    frame = table.to_pandas()
    assert frame["dwt.d2"][0] == table["dwt.d2"][0]
    assert "volterra.coefficients.5" in frame
    assert [row["dwt.d2"] for row in table] == table["dwt.d2"].tolist()
    assert "dwt.d2 [kPa]" in repr(table)
    assert "<td" in table._repr_html_()
    with pytest.raises(KeyError, match=r"dwt\.d2"):
        table["dwt.d22"]


def test_what_cannot_be_measured_says_why(pressure):
    stuck = np.full_like(pressure, 5e6)
    table = hydrofdi.measure([pressure.tolist(), stuck.tolist()], sampling_frequency=RATE)
    assert np.isnan(table["dwt.d2"]).tolist() == [False, True]
    assert table["status"].tolist() == ["ok", "stuck"]
    assert "chamber_1_pressure never changes" in table["reasons"][1]
