"""What a run says of itself."""

import re

import numpy as np
import pytest

from hydrofdi.config import ExperimentConfig, RunParameters
from hydrofdi.config.request import parameter_names
from hydrofdi.execution.compute import Job, compute_columns
from hydrofdi.store import names
from hydrofdi.store.verdicts import DOUBTS, REMEDIES, doubts_of

SHORT = RunParameters().with_values({"record.duration": 2.0, "input.period": 0.5})
SETTLED = {"record.duration": 8.0}
CLIPPED = {"pressure_1_sensor.lowest": 0.0, "pressure_1_sensor.highest": 9e6}


def columns_of(values, coefficient=2e-9):
    return compute_columns([Job("run", SHORT.with_values(values), coefficient)])


def test_the_vapour_limit_decides_what_is_cavitating_which_keeps_its_numbers():
    columns = columns_of({"input.amplitude": 8.0})
    assert columns["verdict"][0].startswith("cavitating, above_supply")
    assert (columns["status"][0], np.all(columns["detail_rms"] > 0.0)) == ("ok", True)
    none, some, more = (
        columns_of({"fluid.vapour_pressure": limit})["cavitating_share"][0] for limit in (0.0, 7e6, 8e6)
    )
    assert none == 0.0 < some < more


def test_a_record_of_one_period_cannot_tell_whether_it_is_settled():
    columns = columns_of({"input.period": 2.0})
    assert np.isnan(columns["settling_change"][0])
    assert "unsettled" not in columns["verdict"][0]


def test_a_sensor_at_an_end_of_its_range_is_reported_with_the_share_of_its_samples():
    columns = columns_of(SETTLED | CLIPPED, 4e-9)
    share = columns["clipped_share"][0]
    assert 0.1 < share == np.mean(columns["chamber_1_pressure"][0] == 9e6) < 0.9
    converted = columns_of(SETTLED | CLIPPED | {"pressure_1_sensor.bits": 7}, 4e-9)
    assert columns["verdict"][0] == converted["verdict"][0] == "clipped"
    assert converted["clipped_share"][0] >= share, "the last level of a converter counts, too"
    for bits in (None, 12):
        wide = {"pressure_1_sensor.highest": 25e6, "pressure_1_sensor.bits": bits}
        columns = columns_of(SETTLED | CLIPPED | wide, 4e-9)
        assert (columns["clipped_share"][0], columns["verdict"][0]) == (0.0, "ok")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "rest", [pytest.param({"valve.lap": 1e-3}, marks=pytest.mark.long), {"input.amplitude": 0.0}]
)
def test_a_record_without_any_motion_is_still_and_settled(rest):
    columns = columns_of(SETTLED | rest)
    assert columns["verdict"][0] == "still"
    assert columns["settling_change"][0] == columns["pressure_variation"][0] == 0.0


@pytest.mark.parametrize(
    "machine",
    [
        {"fluid.bulk_modulus": 689.0},
        {"actuator.mass": 2e6},
        {"actuator.mass": 250.0, "friction.viscous": 0.5, "input.amplitude": 1e-3},
    ],
)
def test_a_machine_that_cannot_exist_is_unusual(machine):
    columns = columns_of(SETTLED | machine, 0.0)
    assert "unusual" in columns["verdict"][0]
    assert columns["status"][0] == "ok"


WIDE = {"input.amplitude": 8.0}
FREE = {"actuator.load_stiffness": 0.0, "input.amplitude": 8.0, "input.period": 2.0}
WILD = {"record.step": 1e-3, "fluid.bulk_modulus": 1e11}


@pytest.mark.parametrize(
    ("word", "values", "turned", "coefficient"),
    [
        ("cavitating", WIDE, {"input.amplitude": 2.0}, 4e-9),
        ("above_supply", WIDE | {"supply.return_pressure": 3e6}, {"supply.pressure": 25e6}, 4e-9),
        ("unsettled", {"input.period": 2.0}, {"record.duration": 20.0}, 0.0),
        ("clipped", {"pressure_1_sensor.highest": 9e6}, {"pressure_1_sensor.highest": 25e6}, 4e-9),
        ("still", {"input.amplitude": 0.0}, {"input.amplitude": 5.0}, 4e-9),
        ("stroke_exceeded", FREE, {"input.period": 0.5}, 4e-9),
        ("diverged", WILD, {"record.step": 1e-5}, 4e-9),
    ],
)
def test_what_a_remedy_names_takes_the_verdict_away(word, values, turned, coefficient):
    told = REMEDIES.get(word, "") or DOUBTS[word].remedy
    assert all(key in told for key in turned)
    columns = columns_of(SETTLED | values, coefficient)
    assert word in columns["verdict"][0].split(", ")
    assert word not in columns_of(SETTLED | values | turned, coefficient)["verdict"][0].split(", ")
    if word in ("stroke_exceeded", "diverged"):
        assert columns["status"][0] == columns["verdict"][0]
        judged = (variable.name for variable in names.JUDGED if not variable.is_text)
        assert all(np.all(np.isnan(columns[name])) for name in ("detail_rms", "clipped_share", *judged))


def test_a_verdict_is_read_back_a_failure_is_no_doubt_and_remedies_name_keys_that_exist():
    assert {doubt.number for doubt in DOUBTS.values()} <= {variable.name for variable in names.COMPUTED}
    assert [doubt.word for doubt in doubts_of("above_supply, still")] == ["above_supply", "still"]
    assert doubts_of("ok") == doubts_of("diverged") == doubts_of("") == ()
    told = " ".join([*(doubt.remedy for doubt in DOUBTS.values()), *REMEDIES.values()])
    known = {*parameter_names(), *(f"limits.{key}" for key in ExperimentConfig().limits.model_dump())}
    assert set(re.findall(r"\b(?!hydrofdi\.)[a-z_0-9]+\.[a-z_]+\b", told)) <= known
