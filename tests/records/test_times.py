"""Time is a channel: its unit, its evenness, and channels that are updated more slowly or not at all."""

import numpy as np
import pytest

import hydrofdi
from hydrofdi.errors import DataError
from hydrofdi.records.defects import update_rate
from hydrofdi.records.source import measured_source, plain_source, write_description
from hydrofdi.records.times import likely_unit
from tests.records.measuring import P1, P2, POSITION, kinds, read

N_TIME, RATE = 2_000, 500.0
TIME = np.arange(N_TIME) / RATE
KEYS = {"P1 [bar]": P1, "P2 [bar]": P2, "x [mm]": POSITION}


def signals():
    """Pressures [bar] and position [mm] of a machine that swings, smooth and without noise."""
    swing = np.sin(2.0 * np.pi * 1.3 * TIME) + 0.3 * np.sin(2.0 * np.pi * 23.0 * TIME + 0.5)
    return dict(zip(KEYS, (80.0 + 20.0 * swing, 90.0 - 20.0 * swing, 10.0 * np.cos(8.1 * TIME)), strict=True))


def written(folder, times, title="time [s]", columns=None, form="{:.6f}"):
    """A CSV of instants that are written as they are, and channels."""
    columns = signals() if columns is None else columns
    rows = zip(times, *columns.values(), strict=True)
    lines = [",".join([str(time), *map(form.format, row)]) for time, *row in rows]
    file = folder / "run.csv"
    file.write_text("\n".join([",".join([title, *columns]), *lines]) + "\n", encoding="utf-8")
    return file


def proposed(file):
    """The record that a proposed description reads as it stands, and its text."""
    text = write_description(file, description := file.parent / "rig.yaml")
    return read(measured_source(description)), text


WITHOUT_UNIT = {
    "µs": np.arange(N_TIME) * 2_000,
    "epoch ms": 1_764_187_200_000 + np.arange(N_TIME) * 2,
    "FILETIME": 132_959_733_843_760_000 + np.arange(N_TIME) * 20_000,
}


@pytest.mark.parametrize("unit", WITHOUT_UNIT)
def test_a_time_without_a_unit_that_is_no_time_in_seconds_is_refused_and_its_unit_proposed(tmp_path, unit):
    file = written(tmp_path, WITHOUT_UNIT[unit], "time")
    with pytest.raises(DataError, match=rf"run\.csv.*{unit.split()[-1]}"):
        plain_source(file)
    batch, _ = proposed(file)
    assert batch.sampling_frequency == pytest.approx(RATE, rel=1e-6)
    assert not kinds(batch)
    np.testing.assert_allclose(batch[P1][0], signals()["P1 [bar]"] * 1e5, atol=0.1)
    assert unit == "µs" or 1.6e9 < batch.dates[0] < 1.8e9


def test_a_slow_time_in_seconds_says_so_and_a_usual_rate_or_an_epoch_is_believed(tmp_path):
    slow = np.arange(N_TIME) * 2.0
    assert read(plain_source(written(tmp_path, slow, "time [s]"))).sampling_frequency == 0.5
    assert likely_unit(TIME) == likely_unit(1_764_187_200.0 + TIME) == likely_unit(TIME[:5] * 1e3) == "s"
    assert not kinds(read(plain_source(written(tmp_path, TIME, "time"))))
    one_row = written(tmp_path, TIME[:1], columns={"P1 [bar]": [80.0]})
    assert "resample" not in write_description(one_row, tmp_path / "rig.yaml")


def test_joined_rasters_need_resample_which_the_proposal_states_with_the_true_rates(tmp_path):
    """Stamps at 500 Hz and others at 100 Hz, 0.3 ms later, as readers join groups of MDF; x is slow."""
    own = TIME[::5] + 0.0003
    times = np.union1d(np.round(TIME, 4), np.round(own, 4))
    columns = {name: np.interp(times, TIME, values) for name, values in signals().items()}
    columns["x [mm]"] = np.interp(times, own, np.interp(own, TIME, signals()["x [mm]"]))
    file = written(tmp_path, times, columns=columns)
    (remark,) = read(plain_source(file)).remarks[0]
    assert (remark.kind, remark.is_unusable, remark.where) == ("uneven", True, "")
    with pytest.raises(DataError, match=r"run\.csv.*resample"):
        hydrofdi.train(file, "dwt", window="0.5 s", false_alarm_rate="45 %", output="d2")
    batch, text = proposed(file)
    assert "resample: 500 Hz" in text
    assert "100 Hz" in text
    assert batch.sampling_frequency == RATE
    assert not any(each.is_unusable for each in batch.remarks[0])
    assert {each.where for each in batch.remarks[0] if each.kind == "held"} == {POSITION}


SINGLE = [f"{each:.9g}" for each in (20_000.0 + TIME).astype(np.float32)]


@pytest.mark.parametrize(("times", "places", "kind"), [
    (SINGLE, np.arange(N_TIME), "rounded"), (SINGLE, np.arange(300), "rounded"),
    (TIME, np.delete(np.arange(N_TIME), 900), "gap"), (5.0 * TIME, np.delete(np.arange(N_TIME), 900), "gap"),
], ids=["single precision", "a short record of it", "a sample lost", "one lost at 100 Hz"])  # fmt: skip
def test_rounded_stamps_are_those_of_an_even_clock_and_one_sample_lost_is_no_rounding(
    tmp_path, times, places, kind
):
    columns = {name: values[places] for name, values in signals().items()}
    batch = read(plain_source(written(tmp_path, np.asarray(times)[places], columns=columns)))
    assert kinds(batch) == {kind}
    assert kind == "gap" or batch.sampling_frequency == RATE


def test_stamps_that_repeat_because_they_are_rounded_name_the_rate(tmp_path):
    (rejected,) = read(plain_source(written(tmp_path, np.round(TIME / 4.0, 3)))).rejected
    assert "sampling_frequency: 2000 Hz" in rejected.remark.message


@pytest.mark.parametrize("n", [2, 5, 10])
def test_a_channel_that_repeats_its_samples_is_remarked_with_its_rate(tmp_path, n):
    columns, smooth = signals(), signals()["P1 [bar]"]
    columns["P1 [bar]"] = np.repeat(smooth[::n], n)
    batch = read(plain_source(written(tmp_path, TIME, columns=columns)))
    (remark,) = batch.remarks[0]
    assert (remark.kind, remark.where, remark.is_unusable) == ("held", P1, False)
    assert update_rate(batch[P1][0], TIME) == pytest.approx(RATE / n, rel=0.02)
    assert update_rate(np.interp(TIME, TIME[::n], smooth[::n]), TIME) == pytest.approx(RATE / n, rel=0.05)


def test_a_coarse_converter_noise_and_rests_are_not_held():
    smooth = signals()["P1 [bar]"]
    noisy = smooth + np.random.default_rng(3).normal(0.0, 0.2, N_TIME)
    resting, square = np.where(TIME < 2.0, noisy, 80.0), np.sign(np.sin(9.0 * TIME))
    for samples in (smooth, noisy, resting, np.round(smooth / 2.0) * 2.0, np.round(noisy), square):
        assert update_rate(samples, TIME) is None


@pytest.mark.parametrize("channel", KEYS)
@pytest.mark.parametrize("part", [slice(1_000, 2_000), slice(300, 1_200)])
def test_a_channel_that_freezes_anywhere_is_stuck(tmp_path, channel, part):
    columns = signals()
    columns[channel][part] = columns[channel][part.start]
    remarks = read(plain_source(written(tmp_path, TIME, columns=columns))).remarks[0]
    assert [each.where for each in remarks if each.kind == "stuck" and each.is_unusable] == [KEYS[channel]]


def test_a_machine_that_comes_to_rest_is_not_frozen(tmp_path):
    """Its pressures repeat for longer than ever before, but decay into it, and nothing else moves."""
    columns = {name: 50.0 + (each - 50.0) * np.exp(-TIME * 12.0) for name, each in signals().items()}
    batch = read(plain_source(written(tmp_path, TIME, columns=columns, form="{:.4f}")))
    assert not any(each.kind == "stuck" for each in batch.remarks[0])
