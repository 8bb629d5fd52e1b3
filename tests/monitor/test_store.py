"""The state of a monitor: its bits come back; what is damaged or of another kind is refused and stays."""

import json
import sqlite3
from contextlib import closing

import numpy as np
import pytest

from hydrofdi.api.streams import monitor_fleet
from hydrofdi.errors import StoreError
from hydrofdi.monitor.store import StateStore, StoredMachine
from tests.monitor.fleets import write_fleet

STATE = {
    "a.held": np.random.default_rng(1).standard_normal((5, 7)), "a.none": np.empty((3, 0)),
    "b.flag": np.array([True, False]), "b.nan": np.array([np.nan, -np.inf]), "b.n": np.array(-3),
}  # fmt: skip
MACHINE = StoredMachine("topic", "digest", {"seen": [1, 2]}, STATE)


@pytest.fixture
def stored(tmp_path):
    store = StateStore(tmp_path / "fleet.db")
    with store.opened():
        store.write({"m'1": MACHINE}, {"place": 3})
    return store


def test_a_state_comes_back_with_the_same_bits(stored):
    with stored.opened():
        found = stored.read("m'1")
        assert stored.read("unknown") is None
        assert stored.read_log() == {"place": 3}
    assert (found.source, found.detector, found.position) == ("topic", "digest", {"seen": [1, 2]})
    assert found.state.keys() == STATE.keys()
    for name, array in STATE.items():
        assert (found.state[name].dtype, found.state[name].shape) == (array.dtype, array.shape)
        assert found.state[name].tobytes() == array.tobytes()


def execute(path, command, *values):
    with closing(sqlite3.connect(path)) as database, database:
        database.execute(command, values)


@pytest.mark.parametrize("column", ["name", "source", "detector", "position", "state"])
def test_a_damaged_cell_is_noticed(stored, column):
    change = f"substr({column}, 1, length({column}) - 1)"
    for changed in (f"cast({change} || '~' as blob)" if column == "state" else f"{change} || '~'", "'text'"):
        execute(stored.path, f"update machine set {column} = {changed}")
        with pytest.raises(StoreError), stored.opened():
            pass


@pytest.mark.parametrize(("column", "forged"), [
    ("position", '"text"'), ("position", "{"), ("state", b""),
    ("state", json.dumps([["number", "|O", []]]).encode() + b"\n" + bytes(8)),
])  # fmt: skip
def test_a_forged_state_is_refused(stored, monkeypatch, column, forged):
    monkeypatch.setattr("hydrofdi.monitor.store._checksum", lambda *row: 0)
    execute(stored.path, f"update machine set {column} = ?, checksum = 0", forged)
    with stored.opened(), pytest.raises(StoreError):
        stored.read("m'1")


@pytest.mark.parametrize("change", [
    lambda path: path.write_text("notes of mine, longer than the header of a database" * 20),
    lambda path: path.unlink() or execute(path, "create table mine (a)"),
    lambda path: execute(path, "pragma user_version = 3"),
    lambda path: path.write_bytes(path.read_bytes()[:-4096]),
    lambda path: path.write_bytes(b"0" * 64 + b"\n{}\nof an earlier version"),
], ids=["text", "database", "version", "cut", "earlier"])  # fmt: skip
def test_what_is_no_state_of_a_fleet_is_refused_and_left_whole(stored, change, tmp_path):
    change(stored.path)
    content = stored.path.read_bytes()
    with pytest.raises(StoreError, match=r"fleet\.db"):
        monitor_fleet(write_fleet(tmp_path, "gone.csv"), follow=False)
    assert stored.path.read_bytes() == content
