"""Channels by their symbols, wherever a file or a setting names one."""

from pathlib import Path

import pytest

import hydrofdi
from hydrofdi.errors import HydrofdiError
from hydrofdi.records import Channel

ROWS = "a,b\n" + "".join(f"{50 + n % 7},{n % 5}\n" for n in range(640))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("rig.csv").write_text(ROWS)
    return tmp_path


def described(channels):
    Path("rig.yaml").write_text(f"files: rig.csv\nsampling_frequency: 1 kHz\nchannels:\n{channels}")
    return "rig.yaml"


def test_a_description_may_name_channels_by_symbols(folder):
    named = hydrofdi.inspect(described("  P1: {column: a, unit: bar}\n  x: {column: b, unit: mm}\n"))
    full = hydrofdi.inspect(
        described("  chamber_1_pressure: {column: a, unit: bar}\n  piston_position: {column: b, unit: mm}\n")
    )
    assert repr(named) == repr(full)


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        ("  P1: {column: a, unit: bar}\n  x: {column: b, unit: bar}\n", "5: channels.x.unit: bar is not"),
        ("  P1: a\n  chamber_1_pressure: b\n", "5: channels.chamber_1_pressure: is given twice, as 'P1' too"),
        ("  P1: a\n  P2: a\n", "5: channels.P2: has the column of chamber_1_pressure"),
        ("  P9: a\n", "4: channels.P9: 'P9' is unknown"),
    ],
)  # fmt: skip
def test_a_mistake_is_found_under_the_name_that_is_written(folder, channels, message):
    with pytest.raises(HydrofdiError, match=rf"rig\.yaml:{message}"):
        hydrofdi.inspect(described(channels))


def test_an_option_takes_the_symbol_and_measures_the_same(folder):
    path = described("  P2: {column: a, unit: bar}\n")
    by_symbol = hydrofdi.measure(path, {"dwt": {"channel": "P2"}})
    by_name = hydrofdi.measure(path, {"dwt": {"channel": "chamber_2_pressure"}})
    assert by_symbol["dwt.d1"].tolist() == by_name["dwt.d1"].tolist()
    assert by_symbol["dwt.d1"][0] > 0.0


def test_the_schema_of_descriptions_takes_what_is_read():
    schema = hydrofdi.schema("measured")
    assert schema["properties"]["channels"]["propertyNames"] == {"$ref": "#/$defs/Channel"}
    names = {name for channel in Channel for name in (channel.value, channel.symbol)}
    assert {*schema["$defs"]["Channel"]["enum"]} == names
