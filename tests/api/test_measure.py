"""`hydrofdi.measure`: the same numbers from whatever holds the samples, and what is refused."""

import numpy as np
import pandas
import pytest
import xarray

import hydrofdi
from tests.commands import run_json

RATE = 500.0
SAID = {"sampling_frequency": "500 Hz"}
PRESSURE = 5e6 + 1e4 * np.random.default_rng(1).standard_normal(4000)
SECONDS = np.arange(PRESSURE.size) / RATE
DATES = pandas.date_range("2026-01-31T12:00", periods=PRESSURE.size, freq="2ms")


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """A file of P1, and its d2 by the command."""
    file = tmp_path_factory.mktemp("rig") / "rig.csv"
    rows = zip(SECONDS.tolist(), PRESSURE.tolist(), strict=True)
    file.write_text("time [s],P1 [Pa]\n" + "".join(f"{time!r},{value!r}\n" for time, value in rows))
    (record,) = run_json("measure", file)["records"]
    return file, record["values"]["dwt.d2"]


FRAME = pandas.DataFrame({"time [s]": SECONDS, "P1 [bar]": PRESSURE / 1e5, "note": "x"})
INDEXED = pandas.DataFrame({"P1 [Pa]": PRESSURE}, index=DATES)
ARRAY = xarray.DataArray(
    PRESSURE, {"time": ("time", SECONDS, {"units": "s"})}, name="chamber_1_pressure", attrs={"units": "Pa"}
)
HOLDERS = {
    "array": (PRESSURE, SAID),
    "list": (PRESSURE.tolist(), {"sampling_frequency": RATE}),
    "mapping": ({"P1 [bar]": PRESSURE / 1e5, "time": SECONDS}, {}),
    "frame with index": (FRAME.set_index("time [s]"), {}),
    "series": (pandas.Series(PRESSURE / 1e5, name="pA"), {"unit": "bar", **SAID}),
    "named column": (FRAME.rename(columns={"P1 [bar]": "A"}), {"channel": {"A": "P1"}, "unit": {"A": "bar"}}),
    "dataset": (xarray.Dataset({"chamber_1_pressure": ARRAY, "chamber_2_pressure": -ARRAY}), {}),
    "data array": (ARRAY, {}),
    "one of several": ({"P1": PRESSURE, "P2": PRESSURE / 1e5}, {"channel": "P1", **SAID}),
    "units beside": (pandas.DataFrame({"t": SECONDS, "P1": PRESSURE}), {"unit": {"t": "s", "P1": "Pa"}}),
    "a counter": (pandas.DataFrame({"Time": np.arange(PRESSURE.size), "P1 [Pa]": PRESSURE}), SAID),
    "dates with a zone": (INDEXED.set_index(DATES.tz_localize("Europe/Berlin")), {}),
    "index of dates": (INDEXED.rename_axis("Zeit"), {}),
    "dates": (INDEXED.rename_axis("timestamp").reset_index(), {}),
    "texts": (INDEXED.rename_axis("Zeitstempel").reset_index().astype({"Zeitstempel": str}), {}),
}


@pytest.mark.parametrize(("data", "options"), HOLDERS.values(), ids=HOLDERS)
def test_whatever_holds_the_samples_and_their_time_gives_the_numbers_of_the_command(data, options, expected):
    table = hydrofdi.measure(data, **options)
    assert len(table) == 1
    np.testing.assert_allclose(table["dwt.d2"], [expected[1]], rtol=1e-9)
    assert table["reasons"].tolist() == [""]


def test_a_table_turns_into_what_people_use():
    table = hydrofdi.measure(PRESSURE, {"dwt": {}, "volterra": {}}, sampling_frequency=RATE)
    data = table.to_xarray()
    assert (data["dwt.d2"].dims, data["dwt.d2"].attrs["units"]) == (("record",), "Pa")
    assert data["volterra.coefficients"].dims == ("record", "volterra.term")
    assert all(each in repr(table) for each in ("dwt.d2", "[kPa]"))
    assert "<td" in table._repr_html_()
    with pytest.raises(KeyError, match=r"dwt\.d2"):
        table["dwt.d22"]


def test_records_side_by_side_are_rows_with_their_names_and_reasons():
    labels = {"label": ["sound", "worn"], "group": "monday"}
    table = hydrofdi.measure(np.stack([PRESSURE, 2.0 * PRESSURE]), sampling_frequency=RATE, **labels)
    np.testing.assert_allclose(table["dwt.d1"][1], 2.0 * table["dwt.d1"][0])
    for found in (table, hydrofdi.measure([INDEXED[:2000], INDEXED], **labels)):
        names = [found[name].tolist() for name in ("record_id", "label", "group")]
        assert names == [["0", "1"], ["sound", "worn"], ["monday", "monday"]]
    stuck = np.full_like(PRESSURE, 5e6)
    table = hydrofdi.measure([PRESSURE.tolist(), stuck.tolist()], sampling_frequency=RATE)
    assert np.isnan(table["dwt.d2"]).tolist() == [False, True]
    assert table["status"].tolist() == ["ok", "stuck"]
    assert "chamber_1_pressure never changes" in table["reasons"][1]
    signals = hydrofdi.simulate(internal_flow="0.2 L/min", duration="4 s").to_xarray()
    units = xarray.DataArray(["new", "old"], dims="unit", name="unit")
    both = xarray.concat([signals.chamber_1_pressure] * 2, dim=units)
    others = signals[["chamber_2_pressure", "input_voltage", "piston_velocity"]]
    table = hydrofdi.measure(others.assign(chamber_1_pressure=both), "dwt,cross_correlation")
    assert table["record_id"].tolist() == ["new", "old"]
    assert table["dwt.d2"][0] == table["dwt.d2"][1]


def test_constants_that_nobody_gave_are_named_by_measure_and_by_a_detector(tmp_path):
    draw, drive = np.random.default_rng(1), np.tile(np.repeat([2.0, -2.0], 250), 2)
    signals = {
        "P1 [Pa]": (8.6e6 + 1e6 * drive, 2e4), "P2 [Pa]": (8.6e6 - 1e6 * drive, 2e4),
        "x [m]": (np.cumsum(drive) * 1e-5, 1e-5), "u [V]": (drive, 1e-3),
    }  # fmt: skip
    records = {name: each + size * draw.standard_normal((40, 1000)) for name, (each, size) in signals.items()}
    one = {"flow_balance": {"spool": "command", "supply": "sum", "piston_area": "20 cm^2"}}
    given = {"chamber_volume": "1 L", "bulk_modulus": "1 GPa", "flow_gain": 0.03, "area_gradient": "20 mm"}
    all_of_them = {"flow_balance": {"supply": "sum", "piston_area": "20 cm^2"} | given}
    remark, *_ = hydrofdi.measure(records, one, sampling_frequency=500.0).remarks
    named = "chamber_volume, bulk_modulus, flow_gain, area_gradient, spool_gain, natural_frequency"
    assert remark.startswith(f"flow_balance: not given: {named}, damping_ratio; the nominal actuator")
    for chosen in ("dwt", all_of_them):
        remarks = hydrofdi.measure(records, chosen, sampling_frequency=500.0).remarks
        assert not any("not given" in remark for remark in remarks)
    assert hydrofdi.measure(hydrofdi.simulate(duration="2 s"), "flow_balance").remarks == ()
    config = {"indicators": one, "output": "leakage", "false_alarm_rate": 0.2}
    detector = hydrofdi.train(records, config=config, accept=True, sampling_frequency=500.0)
    assert "piston_area = 2000 mm², chamber_volume = 280 cm³" in detector.summary
    detector.save(tmp_path / "detector.json")
    assert hydrofdi.Detector.load(tmp_path / "detector.json").summary.count("Warning: flow_balance: ") == 1


@pytest.mark.parametrize("name", ["Druck A (bar)", "Druck A"])
def test_a_column_is_named_with_or_without_its_unit(name, expected):
    frame, named = pandas.DataFrame({"Druck A (bar)": PRESSURE / 1e5}), {"channel": {name: "P1"}, **SAID}
    for unit in ({}, {"unit": {name: "bar"}}):
        assert hydrofdi.measure(frame, **named, **unit)["dwt.d2"][0] == pytest.approx(expected[1])
    with pytest.raises(hydrofdi.HydrofdiError, match="the file says bar, the description says Pa"):
        hydrofdi.measure(frame, **named, unit={name: "Pa"})
