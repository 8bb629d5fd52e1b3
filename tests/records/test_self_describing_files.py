"""Files whose headers say what they are: in a folder, or under a description of files alone."""

import numpy as np
import pytest

import hydrofdi
from hydrofdi.api.records.sources import open_source
from hydrofdi.errors import ConfigError, DataError
from tests.commands import run, run_json
from tests.records.measuring import P1, P2, batches, csv_of, described

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
