"""``hydrofdi diagnose``: files, arrays, wrong wiring, missing channels."""

import json

import numpy as np
import pytest

import hydrofdi
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records import Channel
from tests.commands import run
from tests.diagnosis.conftest import N_HEALTHY

SYMBOLS = {"P1": "Pa", "P2": "Pa", "x": "m", "u": "V"}
FLOW = 0.2e-3 / 60.0


def write_all(folder, data, rate):
    """A folder with a file of each record."""
    folder.mkdir()
    head = ",".join(["time [s]", *(f"{name} [{unit}]" for name, unit in SYMBOLS.items())])
    for row, samples in enumerate(zip(*(data[Channel(name)] for name in SYMBOLS), strict=True)):
        table = np.column_stack((np.arange(samples[0].size) / rate, *samples))
        np.savetxt(folder / f"day{row}.csv", table, "%.17g", ",", header=head, comments="")
    return folder


def in_memory(batch, **renamed):
    """Records as columns, some with other samples."""
    return {Channel(name): batch[Channel(renamed.get(name, name))] for name in SYMBOLS}


@pytest.fixture(scope="module")
def diagnosed(healthy):
    """The diagnosis of columns in memory, by default with the history of the healthy days."""

    def found(data, history=None, **more):
        past = in_memory(healthy) if history is None else history
        options = {"flow_balance": {"return_pressure": "4 bar"}}
        return hydrofdi.diagnose(
            data, past or None, options, sampling_frequency=healthy.sampling_frequency, **more
        )

    return found


@pytest.fixture(scope="module")
def leaking(days):
    """A day with a leaking seal."""
    return days([{"leakage.internal_coefficient": FLOW / 8e6**0.5}], first=700)


def test_the_command_names_the_fault_of_a_file(healthy, leaking, tmp_path):
    write_all(tmp_path / "healthy", in_memory(healthy), healthy.sampling_frequency)
    today = write_all(tmp_path / "today", in_memory(leaking), leaking.sampling_frequency)
    (today / "day0.csv").rename(tmp_path / "today.csv")
    done = run("diagnose", "today.csv", "--history", "healthy", "--json", cwd=tmp_path, check=0)
    found = json.loads(done.stdout)
    assert (found["healthy_records"], found["sensors"]) == (N_HEALTHY, "P1 P2 x u")
    first = found["records"][0]["findings"][0]
    assert first["name"] == found["records"][0]["name"] == "seal_orifice"
    assert first["size"] == pytest.approx(FLOW, rel=0.3)
    shown = run("diagnose", "today.csv", "--history", "healthy", cwd=tmp_path, check=0).stdout
    assert "piston seal" in shown
    again = run("diagnose", "healthy/day0.csv", "--history", "healthy", "--json", cwd=tmp_path, check=0)
    assert json.loads(again.stdout)["records"][0]["name"] == "healthy"


def test_wrong_wiring_is_named(diagnosed, days):
    day = days([{}], first=800)
    wired = {
        "swapped_pressures": in_memory(day, P1="P2", P2="P1"),
        "wrong_sign_u": in_memory(day) | {Channel("u"): -day[Channel("u")]},
        "wrong_sign_x": in_memory(day) | {Channel("x"): -day[Channel("x")]},
    }
    data = {Channel(name): np.vstack([each[Channel(name)] for each in wired.values()]) for name in SYMBOLS}
    assert [each.name for each in diagnosed(data).records] == [*wired]


def test_labelled_records_bring_their_history(diagnosed, healthy, leaking):
    data = {name: np.vstack((healthy[name], leaking[name])) for name in in_memory(healthy)}
    labels = ["healthy"] * N_HEALTHY + ["worn"]
    whole, apart = diagnosed(data, (), label=labels, healthy="healthy"), diagnosed(in_memory(leaking))
    assert [each.name for each in whole.records] == ["seal_orifice"]
    assert whole.records[0].findings == apart.records[0].findings
    assert set(whole.table["name"]) == {each.name for each in whole.records[0].named}


def test_what_cannot_be_told_is_an_error(diagnosed, leaking, tmp_path):
    data, frequency = in_memory(leaking), leaking.sampling_frequency
    short = {name: samples for name, samples in data.items() if name != Channel.PISTON_POSITION}
    with pytest.raises(DataError, match="missing: x"):
        hydrofdi.diagnose(short, sampling_frequency=frequency)
    whole = {name: np.vstack((samples, samples)) for name, samples in data.items()}
    halved = {name: samples[:, ::2] for name, samples in whole.items()}
    mixed = [
        write_all(tmp_path / "whole", whole, frequency),
        write_all(tmp_path / "half", halved, frequency / 2),
    ]
    with pytest.raises(DataError, match="Hz"):
        hydrofdi.diagnose(write_all(tmp_path / "today", in_memory(leaking, P1="P2"), frequency), mixed)
    with pytest.raises(ConfigError, match="half_windo"):
        hydrofdi.diagnose(data, None, {"flow_balance": {"half_windo": 8}}, sampling_frequency=frequency)


def changed(data, channel, change):
    """Records with other samples of a channel."""
    return data | {channel: change(data[channel].copy())}


def spoilt(value):
    def change(samples):
        samples[0, 50] = value
        return samples

    return lambda data: changed(data, Channel.CHAMBER_1_PRESSURE, change)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda data: {name: samples[:, :900] for name, samples in data.items()}, "needed"),
        (lambda data: {name: samples[:, ::2] for name, samples in data.items()}, "Hz"),
        (lambda data: changed(data, Channel.PISTON_POSITION, lambda samples: 0.2 * samples), "way"),
        (lambda data: {name: 1e-3 * samples for name, samples in data.items()}, "unit"),
        (lambda data: {name: 0.0 * samples for name, samples in data.items()}, ""),
        (spoilt(1e200), "chamber_1_pressure"),
        (spoilt(np.nan), ""),
    ],
)
def test_a_record_of_another_kind_is_not_judged(change, word, healthy, leaking, tmp_path):
    data, rate = change(in_memory(leaking)), leaking.sampling_frequency
    path = write_all(tmp_path / "today", data, rate / 2 if word == "Hz" else rate) / "day0.csv"
    four = {name: samples[:4] for name, samples in in_memory(healthy).items()}
    (found,) = hydrofdi.diagnose(path, write_all(tmp_path / "healthy", four, rate)).records
    assert (found.name, found.findings) == ("", ())
    assert found.reason
    assert word in found.reason


def test_a_long_record_is_cut_like_the_history(diagnosed, leaking):
    data = {name: np.hstack((samples, samples)) for name, samples in in_memory(leaking).items()}
    found = diagnosed(data)
    assert [each.name for each in found.records] == ["seal_orifice"] * 2
    assert all("–" in each.record_id for each in found.records)


def test_a_record_under_test_is_no_history(diagnosed, healthy, leaking):
    both = {name: np.vstack((healthy[name], leaking[name])) for name in in_memory(healthy)}
    apart, found = diagnosed(in_memory(leaking)), diagnosed(in_memory(leaking), both)
    assert found.n_healthy == apart.n_healthy == N_HEALTHY
    assert len(found.remarks) == len(apart.remarks) + 1
    assert found.records[0].findings == apart.records[0].findings


def test_a_record_of_the_history_that_is_unlike_the_others_is_named(diagnosed, healthy, days, leaking):
    strange = days([{"supply.pressure": 14e6}], first=720)
    mixed = {name: np.vstack((healthy[name], strange[name])) for name in in_memory(healthy)}
    found = diagnosed(in_memory(leaking), mixed)
    assert found.n_healthy == N_HEALTHY
    (remark,) = [each for each in found.remarks if "unlike" in each]
    assert f": {N_HEALTHY}, " in remark
    assert "low supply pressure" in remark
    assert found.counts == {"seal_orifice": 1}


def test_beside_healthy_stands_what_would_have_been_seen(diagnosed, days):
    found = diagnosed(in_memory(days([{}], first=730)))
    visible = {each.name: each.visible for each in found.records[0].findings if not np.isnan(each.visible)}
    assert found.records[0].name == "healthy"
    leaks = {"leakage.internal_coefficient": 2.0 * visible["seal_orifice"] / 8e6**0.5}
    supply = {"supply.pressure": 17.2e6 - 2.0 * visible["weak_supply"]}
    again = diagnosed(in_memory(days([leaks, supply], first=740)))
    assert [each.name for each in again.records] == ["seal_orifice", "weak_supply"]


def test_a_model_that_explains_nothing_does_not_say_healthy(diagnosed, healthy):
    draw = np.random.default_rng(5)
    shuffled = {
        name: np.stack([np.roll(row, int(draw.integers(row.size))) for row in draw.permutation(samples)])
        for name, samples in in_memory(healthy).items()
    }
    (found,) = diagnosed({name: samples[:1] for name, samples in shuffled.items()}, shuffled).records
    assert not found.findings
    assert found.reason
