"""Files whose headers say what they are: in a folder, or under a description of files alone."""

import gzip
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import hydrofdi
from hydrofdi.api.records.sources import open_source
from hydrofdi.errors import ConfigError, DataError, HydrofdiError
from hydrofdi.records import Channel
from hydrofdi.records.measured.columns import NAMES
from hydrofdi.records.measured.source import measured_source
from tests.commands import run, run_hydrofdi, run_json
from tests.conftest import REPOSITORY
from tests.records.measuring import P1, P2, SUPPLY, batches, csv_of, described

TIME = np.arange(400) / 200.0
NOISE = np.random.default_rng(8).normal(0.0, 1.0, (3, TIME.size))


def _text(row=0, p1="P1 [bar]", time="time [s]", factor=1.0):
    return csv_of((time, TIME), (p1, (80 + NOISE[row]) * factor), ("P2 [bar]", 60 + NOISE[row]))


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "rig"
    place.mkdir()
    (place / "run 2.csv").write_text(_text(0))
    (place / "run 10.csv").write_text(_text(1, "P1 [MPa]", factor=0.1))
    (place / "readme.txt").write_text("Recorded on a Monday.\n")
    (place / ".hidden.csv").write_text("nothing")
    return place


def test_a_folder_of_such_files_is_measured_as_its_files_are(folder):
    together = hydrofdi.measure(folder, "dwt")
    one_by_one = hydrofdi.measure([folder / "run 2.csv", folder / "run 10.csv"], "dwt")
    assert together["record_id"].tolist() == ["run 2.csv", "run 10.csv"]
    np.testing.assert_array_equal(together["dwt.d3"], one_by_one["dwt.d3"])


def test_an_export_of_a_sweep_is_measured_by_its_folder(small_sweep, tmp_path):
    for form in ("csv", "mat"):
        run("export", small_sweep.directory, "--out", tmp_path / form, "--format", form, check=0)
        values = [
            [record["values"] for record in run_json("measure", source)["records"]]
            for source in (tmp_path / form, small_sweep.directory)
        ]
        assert values[0] == values[1]


def test_a_description_of_files_alone_takes_channels_units_and_time_from_headers(folder):
    source = open_source(described(folder, 'files: "*.csv"\ngroup: "{file}"\ndrive_period: 1 s\n'))
    (batch,) = source.batches()
    assert set(batch.channels) == {P1, P2}
    assert (batch.sampling_frequency, batch.drive_period) == (200.0, 1.0)
    np.testing.assert_allclose(batch[P1], (80 + NOISE[:2]) * 1e5)
    with pytest.raises(ConfigError, match=r"measured.yaml:2: segment: needs the channel piston_position"):
        open_source(described(folder, 'files: "*.csv"\nsegment: {part: motion}\n'))


def test_the_first_file_that_can_be_read_states_the_columns(folder):
    (folder / "run 1.csv").write_text("")
    (batch,) = open_source(folder).batches()
    assert [each.record_id for each in batch.rejected] == ["run 1.csv"]
    assert batch.n_record == 2


def test_columns_that_nobody_recognises_are_named_and_a_file_with_other_columns_is_refused(folder):
    (folder / "run 2.csv").write_text(_text().replace("P2 [bar]", "torque [Nm]"))
    (folder / "run 10.csv").write_text(_text(1))
    (batch,) = open_source(folder).batches()
    assert batch.remarks[0][0].message == "columns not used: torque [Nm]"
    (folder / "run 10.csv").write_text(_text(1).replace("P1 [bar]", "pressure_sensor [bar]"))
    with pytest.raises(DataError, match=r"run 10.csv: has no column 'P1'"):
        list(open_source(folder).batches())


def test_a_folder_says_its_sampling_frequency_or_is_told_it(tmp_path):
    (tmp_path / "run.csv").write_text(csv_of(("P1 [bar]", 80 + NOISE[0])))
    with pytest.raises(DataError, match="no sampling frequency is given"):
        open_source(tmp_path)
    (batch,) = open_source(tmp_path, sampling_frequency=50.0).batches()
    assert batch.sampling_frequency == 50.0


def test_a_folder_with_a_description_asks_for_its_name(folder):
    file = described(folder, 'files: "*.csv"\n')
    with pytest.raises(DataError, match=f"contains a description of measured files; name it: {file}"):
        open_source(folder)


def test_a_single_batch_of_a_description_without_channels_or_sampling_is_refused(tmp_path):
    with pytest.raises(DataError, match="no column is named like a channel; found q"):
        batches(tmp_path, 'files: "*.csv"\n', run_csv="q [bar]\n1\n2\n")


ROWS = "a,b\n" + "".join(f"{50 + n % 7},{n % 5}\n" for n in range(640))


@pytest.fixture
def folder_symbols(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("rig.csv").write_text(ROWS)
    return tmp_path


def described_of_symbols(channels):
    Path("rig.yaml").write_text(f"files: rig.csv\nsampling_frequency: 1 kHz\nchannels:\n{channels}")
    return "rig.yaml"


def test_a_description_may_name_channels_by_symbols(folder_symbols):
    named = hydrofdi.inspect(
        described_of_symbols("  P1: {column: a, unit: bar}\n  x: {column: b, unit: mm}\n")
    )
    full = hydrofdi.inspect(
        described_of_symbols(
            "  chamber_1_pressure: {column: a, unit: bar}\n  piston_position: {column: b, unit: mm}\n"
        )
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
def test_a_mistake_is_found_under_the_name_that_is_written(folder_symbols, channels, message):
    with pytest.raises(HydrofdiError, match=rf"rig\.yaml:{message}"):
        hydrofdi.inspect(described_of_symbols(channels))


def test_an_option_takes_the_symbol_and_measures_the_same(folder_symbols):
    path = described_of_symbols("  P2: {column: a, unit: bar}\n")
    by_symbol = hydrofdi.measure(path, {"dwt": {"channel": "P2"}})
    by_name = hydrofdi.measure(path, {"dwt": {"channel": "chamber_2_pressure"}})
    assert by_symbol["dwt.d1"].tolist() == by_name["dwt.d1"].tolist()
    assert by_symbol["dwt.d1"][0] > 0.0


def test_the_schema_of_descriptions_takes_what_is_read():
    schema = hydrofdi.schema("measured")
    assert schema["properties"]["channels"]["propertyNames"] == {"$ref": "#/$defs/Channel"}
    names = {name for channel in Channel for name in (channel.value, channel.symbol)}
    assert {*schema["$defs"]["Channel"]["enum"]} == names


@pytest.mark.parametrize("line", ["x " * 500_000, "P1 [bar" * 100_000, ",".join(["a" * 2000] * 500)])
def test_a_huge_first_line_is_refused_in_a_short_sentence(tmp_path, line):
    (tmp_path / "huge.csv").write_text(f"{line}\n1,2,3\n")
    done = run_hydrofdi("inspect", "huge.csv", cwd=tmp_path)
    assert done.returncode == 2
    assert len(done.stderr) < 3000


ROWS_UNITS = "".join(f"{0.01 * n:.2f},{100 + n % 7},{20 + n % 3}\n" for n in range(50))


def inspected(folder, *arguments):
    lines = run("inspect", *arguments, cwd=folder).stdout.splitlines()
    rows = (line.split() for line in lines)
    return {row[0]: row[1:5] for row in rows if len(row) == 6}


def test_channels_are_shown_in_the_unit_of_their_file(tmp_path):
    (tmp_path / "a.csv").write_text(f"time [s],P1 [bar],x [mm]\n{ROWS_UNITS}")
    channels = inspected(tmp_path, "a.csv")
    assert channels["chamber_1_pressure"] == ["bar", "100", "102.9", "106"]
    assert channels["piston_position"] == ["mm", "20", "20.98", "22"]


def test_si_and_files_of_different_units_are_shown_by_size(tmp_path):
    si = ROWS_UNITS.replace(",10", ",1000000")
    (tmp_path / "si.csv").write_text(f"time [s],P1 [Pa],x [mm]\n{si}")
    assert inspected(tmp_path, "si.csv")["chamber_1_pressure"][0] == "MPa"
    for name, unit in (("b", "bar"), ("p", "psi")):
        (tmp_path / f"{name}.csv").write_text(f"time [s],P1 [{unit}],x [mm]\n{ROWS_UNITS}")
    both = "files: '?.csv'\nchannels: {chamber_1_pressure: P1, piston_position: x}\ntime: {column: time}\n"
    (tmp_path / "both.yaml").write_text(both)
    assert inspected(tmp_path, "both.yaml")["chamber_1_pressure"][0] == "MPa"


def test_counts_have_no_unit_to_show(tmp_path):
    (tmp_path / "raw.csv").write_text(f"time [s],P1 [counts],x [mm]\n{ROWS_UNITS}")
    assert inspected(tmp_path, "raw.csv")["chamber_1_pressure"] == ["counts", "100", "102.9", "106"]


PAGE = (REPOSITORY / "docs" / "measured.md").read_text(encoding="utf-8")


def test_the_example_of_the_page_reads_a_file_as_it_says(tmp_path):
    example, *_ = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
    time = np.arange(9000)
    voltage = np.where(time // 1000 % 4 < 2, 2, -2)
    columns = [time, 100 + time % 7, 90 + time % 5, 4 + time % 2, -0.05 * (time % 4000), voltage]
    rows = "\n".join(
        ";".join(f"{value:g}".replace(".", ",") for value in row) for row in np.transpose(columns)
    )
    folder = tmp_path / "runs" / "unit 7"
    folder.mkdir(parents=True)
    header = "t [ms];P1 [bar];P2;I_s [mA];x;u\n"
    (folder / "sealed 3.csv.gz").write_bytes(gzip.compress((header + rows).encode()))
    batch = next(measured_source(described(tmp_path, example)).batches(labels=True))
    assert batch.record_ids[0] == "runs/unit 7/sealed 3.csv.gz#1"
    assert (batch.groups[0].split(",")[0], batch.labels[0]) == ("7", "sealed")
    assert batch.n_time == 2000
    assert 100e5 <= batch[P1].min() <= batch[P1].max() <= 106e5
    np.testing.assert_allclose(np.unique(batch[SUPPLY]), [0.0, 15.625e5], atol=1e-6)


def test_the_page_names_every_remark():
    package = REPOSITORY / "hydrofdi" / "records" / "measured"
    sources = "".join(file.read_text(encoding="utf-8") for file in package.rglob("*.py"))
    kinds = set(re.findall(r'kind="(\w+)"', sources)) | {"clipped", "saturated"}
    assert len(kinds) > 10
    assert {kind for kind in kinds if f"`{kind}`" not in PAGE} == set()


def test_the_page_lists_the_names_that_plain_files_are_read_by():
    for channel, names in NAMES.items():
        assert f"| `{channel}` | {names} |" in PAGE


def test_the_kept_schemas_and_pages_are_those_of_the_models():
    generator = REPOSITORY / "docs" / "generate_configuration.py"
    subprocess.run([sys.executable, str(generator), "--check"], check=True)
    kept = json.loads((REPOSITORY / "configs" / "measured-schema.json").read_text())
    assert kept == json.loads(run("schema", "measured", check=0).stdout)
    assert kept["properties"]["channels"]["propertyNames"]
