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
OPTIONS = {"return_pressure": "4 bar"}


def write(path, samples, rate):
    """A CSV file of a record: symbol → samples."""
    head = ",".join(["time [s]", *(f"{name} [{unit}]" for name, unit in SYMBOLS.items())])
    time = np.arange(len(samples["P1"])) / rate
    rows = np.column_stack((time, *(samples[name] for name in SYMBOLS)))
    np.savetxt(path, rows, "%.17g", ",", header=head, comments="")


def write_all(folder, data, rate):
    """A folder with a file of each record."""
    folder.mkdir()
    for row in range(len(data[Channel.PISTON_POSITION])):
        write(folder / f"day{row}.csv", {name: data[Channel(name)][row] for name in SYMBOLS}, rate)
    return folder


def in_memory(batch, **renamed):
    """Records as columns, some with other samples."""
    return {Channel(name): batch[Channel(renamed.get(name, name))] for name in SYMBOLS}


@pytest.fixture(scope="module")
def diagnosed(healthy):
    """The diagnosis of columns in memory, by default with the history of the healthy days."""

    def found(data, history=None, **more):
        past = in_memory(healthy) if history is None else history
        rate = healthy.sampling_frequency
        return hydrofdi.diagnose(
            data, past or None, {"flow_balance": OPTIONS}, sampling_frequency=rate, **more
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
    assert found["healthy_records"] == N_HEALTHY
    assert found["sensors"] == "P1 P2 x u"
    first = found["records"][0]["findings"][0]
    assert first["name"] == found["records"][0]["name"] == "seal_orifice"
    assert first["size"] == pytest.approx(FLOW, rel=0.3)
    shown = run("diagnose", "today.csv", "--history", "healthy", cwd=tmp_path, check=0).stdout
    assert "piston seal" in shown
    assert "L/min" in shown
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


def test_what_cannot_be_told_is_an_error(leaking, tmp_path):
    data, frequency = in_memory(leaking), leaking.sampling_frequency
    del data[Channel.PISTON_POSITION]
    with pytest.raises(DataError, match="missing: x"):
        hydrofdi.diagnose(data, sampling_frequency=frequency)
    still = {name: np.zeros_like(samples) for name, samples in in_memory(leaking).items()}
    (found,) = hydrofdi.diagnose(still, sampling_frequency=frequency).records
    assert not found.findings
    assert found.reason
    data = in_memory(leaking)
    halved = {name: np.vstack((samples, samples))[:, ::2] for name, samples in data.items()}
    whole = {name: np.vstack((samples, samples)) for name, samples in data.items()}
    mixed = [
        write_all(tmp_path / "whole", whole, frequency),
        write_all(tmp_path / "half", halved, frequency / 2),
    ]
    with pytest.raises(DataError, match="Hz"):
        hydrofdi.diagnose(write_all(tmp_path / "today", in_memory(leaking, P1="P2"), frequency), mixed)
    with pytest.raises(ConfigError, match="half_windo"):
        hydrofdi.diagnose(
            in_memory(leaking), None, {"flow_balance": {"half_windo": 8}}, sampling_frequency=frequency
        )


def test_a_record_with_a_hole_is_not_judged(diagnosed, leaking):
    data = {name: samples.copy() for name, samples in in_memory(leaking).items()}
    data[Channel.CHAMBER_1_PRESSURE][0, 50] = np.nan
    (found,) = diagnosed(data, ()).records
    assert not found.findings
    assert found.reason


def spiked(data):
    """Records with one absurd sample of P1."""
    pressure = data[Channel.CHAMBER_1_PRESSURE].copy()
    pressure[0, 50] = 1e200
    return data | {Channel.CHAMBER_1_PRESSURE: pressure}


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda data, rate: ({name: samples[:, :900] for name, samples in data.items()}, rate), "needed"),
        (lambda data, rate: ({name: samples[:, ::2] for name, samples in data.items()}, rate / 2), "Hz"),
        (
            lambda data, rate: (data | {Channel.PISTON_POSITION: 0.2 * data[Channel.PISTON_POSITION]}, rate),
            "way",
        ),
        (lambda data, rate: ({name: 1e-3 * samples for name, samples in data.items()}, rate), "unit"),
        (lambda data, rate: (spiked(data), rate), "chamber_1_pressure"),
    ],
)
def test_a_record_of_another_kind_is_not_judged(change, word, healthy, leaking, tmp_path):
    data, rate = change(in_memory(leaking), leaking.sampling_frequency)
    path = write_all(tmp_path / "today", data, rate) / "day0.csv"
    four = {name: samples[:4] for name, samples in in_memory(healthy).items()}
    write_all(tmp_path / "healthy", four, healthy.sampling_frequency)
    found = hydrofdi.diagnose(path, tmp_path / "healthy")
    assert found.records[0].name == ""
    assert word in found.records[0].reason


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


def test_beside_healthy_stands_what_would_have_been_seen(diagnosed, healthy, days):
    found = diagnosed(in_memory(days([{}], first=730)))
    visible = {each.name: each.visible for each in found.records[0].findings if not np.isnan(each.visible)}
    assert found.records[0].name == "healthy"
    leaks = {"leakage.internal_coefficient": 2.0 * visible["seal_orifice"] / 8e6**0.5}
    supply = {"supply.pressure": 17.2e6 - 2.0 * visible["weak_supply"]}
    again = diagnosed(in_memory(days([leaks, supply], first=740)))
    assert [each.name for each in again.records] == ["seal_orifice", "weak_supply"]
    assert len(healthy.record_ids) == N_HEALTHY


def test_a_model_that_explains_nothing_does_not_say_healthy(diagnosed, healthy):
    draw = np.random.default_rng(5)
    shuffled = {
        name: np.stack([np.roll(row, int(draw.integers(row.size))) for row in draw.permutation(samples)])
        for name, samples in in_memory(healthy).items()
    }
    (found,) = diagnosed({name: samples[:1] for name, samples in shuffled.items()}, shuffled).records
    assert not found.findings
    assert found.reason
