"""``store.signals`` names the signals that are kept."""

import h5py
import pytest

from hydrofdi.api.plan import plan_sweep
from hydrofdi.api.sweep import run_sweep
from hydrofdi.config import load_experiment
from hydrofdi.config.experiment import SIGNALS, StoreConfig
from hydrofdi.execution import InProcessEngine
from hydrofdi.store.layout import names

SHORT = ["record.duration=1 s"]


def test_signals_of_the_configuration_are_those_of_files():
    assert SIGNALS == names.SIGNALS


@pytest.mark.parametrize(
    ("given", "text"),
    [
        (["spool_position", "chamber_1_pressure"], "spool_position,chamber_1_pressure"),
        (["chamber_1_pressure", "spool_position"], "spool_position,chamber_1_pressure"),
        (["chamber_2_pressure", "chamber_1_pressure"], "pressures"),
        ([], "none"),
        (list(SIGNALS), "all"),
    ],
)
def test_a_choice_of_signals_has_one_text_and_is_read_back(given, text):
    store = StoreConfig(signals=given)
    assert store.signals == text
    assert StoreConfig.model_validate_json(store.model_dump_json()) == store


def test_just_the_listed_signals_are_stored_and_what_holds_them_is_not_computed_again(tmp_path):
    listed = load_experiment(settings=[*SHORT, "store.signals=[spool_position, chamber_1_pressure]"])
    file = run_sweep(listed, tmp_path, InProcessEngine()).file
    with h5py.File(file) as stored:
        assert {name for name in SIGNALS if name in stored} == {"spool_position", "chamber_1_pressure"}
    fewer = load_experiment(settings=[*SHORT, "store.signals=[spool_position]"])
    others = load_experiment(settings=[*SHORT, "store.signals=[spool_position, piston_position]"])
    assert not plan_sweep(fewer, tmp_path).missing
    assert plan_sweep(others, tmp_path).simulated
