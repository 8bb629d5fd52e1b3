"""What the messages advise leads to right numbers, never to a scale that nobody stated."""

from textwrap import dedent

import pytest

from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records.measured.source import measured_source, plain_source
from tests.records.measuring import P1, USUAL, batches, kinds, one


def test_another_spelling_agrees_with_its_unit_alone(tmp_path):
    batch = one(tmp_path, a_csv="P1 [Bar]\n1\n2\n")
    assert batch[P1].tolist() == [[1e5, 2e5]]
    assert "unknown_unit" not in kinds(batch)
    with pytest.raises(DataError, match="the file says Bar, the description says Pa"):
        batches(tmp_path, USUAL.replace("bar", "Pa"), a_csv="P1 [Bar]\n1\n2\n")


def test_a_scale_that_the_header_may_contradict_is_remarked(tmp_path):
    batch = one(tmp_path, a_csv="P1 [torr]\n1\n2\n")
    (text,) = [remark.message for remark in batch.remarks[0] if remark.kind == "unknown_unit"]
    assert "the header says 'torr', the description 'bar'" in text


def plain(folder, text):
    file = folder / "run.csv"
    file.write_text(text)
    return next(iter(plain_source(file).batches()))


@pytest.mark.parametrize("text", ["time,P1 [bar]\n0,1\n1,2\n", "foo [bar]\n1\n2\n", "P1\n1\n2\n"])
def test_a_suggestion_that_is_copied_as_it_is_gives_no_numbers(tmp_path, text):
    with pytest.raises(DataError) as raised:
        plain(tmp_path, text)
    _, suggestion = str(raised.value).split("YAML file:\n")
    (tmp_path / "m.yaml").write_text(dedent(suggestion), encoding="utf-8")
    with pytest.raises((ConfigError, DataError)):
        list(measured_source(tmp_path / "m.yaml").batches())


def test_the_unit_decides_what_is_time(tmp_path):
    batch = plain(tmp_path, "T [bar],time [s],t [s],P1 [bar]\n5,0,7,1\n5,0.5,9,2\n")
    assert batch.sampling_frequency == 2.0
    assert "columns not used: T [bar], t [s]" in [remark.message for remark in batch.remarks[0]]


def test_a_sampling_frequency_against_the_column_of_time_is_remarked(tmp_path):
    assert "sampling_differs" in kinds(one(tmp_path, a_csv="time [s],P1 [bar]\n0,1\n0.5,2\n1,3\n"))
    assert "sampling_differs" not in kinds(one(tmp_path, a_csv="time [ms],P1 [bar]\n0,1\n1,2\n2,3\n"))


@pytest.mark.parametrize(("value", "is_spike"), [(-9999, True), (1000, True), (8, False)])
def test_one_implausible_sample_is_remarked(tmp_path, value, is_spike):
    samples = [number % 7 for number in range(400)]
    samples[56] = value
    batch = one(tmp_path, a_csv="P1 [bar]\n" + "\n".join(map(str, samples)) + "\n")
    assert ("spike" in kinds(batch)) == is_spike


def test_files_of_one_set_that_differ_are_remarked(tmp_path):
    gained = "files: '*.csv'\ntime: time\nchannels: {chamber_1_pressure: {column: P1, unit: bar, gain: 2}}\n"
    gained = gained.replace("time: time", "time: {column: time}")
    texts = {f"{name}_csv": f"time [s],P1 [{unit}]\n0,1\n{step},2\n" for name, unit, step in
             [("a", "V", 1), ("b", "V", 1), ("c", "mV", 2)]}  # fmt: skip
    found = [
        kinds(batch, row) for batch in batches(tmp_path, gained, **texts) for row in range(batch.n_record)
    ]
    wanted = {"sampling_varies", "units_vary"}
    assert [kinds & wanted for kinds in found] == [set(), set(), wanted]
