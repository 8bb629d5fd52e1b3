"""What a run says of itself."""

import re
from typing import Any

import numpy as np
import pytest

from hydrofdi.config import ExperimentConfig, RunParameters
from hydrofdi.config.request import parameter_names
from hydrofdi.execution.compute import Job, compute_columns
from hydrofdi.store import names
from hydrofdi.store.verdicts import DOUBTS, REMEDIES, doubts_of

SHORT = RunParameters().with_values({"record.duration": 2.0, "input.period": 0.5})
SETTLED = {"record.duration": 8.0}


def _columns(values: dict[str, object], coefficient: float = 2e-9) -> dict[str, np.ndarray]:
    return compute_columns([Job("run", SHORT.with_values(values), coefficient)])


def test_wide_valve_opening_makes_a_run_cavitating_but_keeps_its_numbers() -> None:
    columns = _columns({"input.amplitude": 8.0})
    assert columns["verdict"][0].startswith("cavitating, above_supply")
    assert columns["above_supply_share"][0] > 0.0
    assert 0.0 < columns["cavitating_share"][0] < 0.5
    assert columns["status"][0] == "ok"
    assert np.all(columns["detail_rms"] > 0.0)


def test_vapour_limit_decides_what_is_cavitating() -> None:
    shares = [_columns({"fluid.vapour_pressure": limit})["cavitating_share"][0] for limit in (0.0, 7e6, 8e6)]
    assert shares[0] == 0.0
    assert 0.0 < shares[1] < shares[2]


def test_record_of_one_period_cannot_tell_whether_it_is_settled() -> None:
    columns = _columns({"input.period": 2.0})
    assert np.isnan(columns["settling_change"][0])
    assert "unsettled" not in columns["verdict"][0]


CLIPPED = {"pressure_1_sensor.lowest": 0.0, "pressure_1_sensor.highest": 9e6}


def test_sensor_at_an_end_of_its_range_is_reported_with_the_share_of_its_samples() -> None:
    columns = _columns(SETTLED | CLIPPED, coefficient=4e-9)
    at_end = columns["chamber_1_pressure"][0] == 9e6
    assert columns["verdict"][0] == "clipped"
    assert 0.1 < columns["clipped_share"][0] == np.mean(at_end) < 0.9


@pytest.mark.parametrize("bits", [None, 12])
def test_sensor_whose_range_holds_the_record_is_not_clipped(bits: int | None) -> None:
    wide = {"lowest": 0.0, "highest": 25e6, "bits": bits}
    columns = _columns(SETTLED | {f"pressure_1_sensor.{k}": v for k, v in wide.items()}, coefficient=4e-9)
    assert columns["clipped_share"][0] == 0.0
    assert columns["verdict"][0] == "ok"


def test_converter_on_its_last_level_counts_as_clipped() -> None:
    columns = _columns(SETTLED | CLIPPED | {"pressure_1_sensor.bits": 7}, coefficient=4e-9)
    assert columns["verdict"][0] == "clipped"
    assert columns["clipped_share"][0] >= _columns(SETTLED | CLIPPED, 4e-9)["clipped_share"][0] > 0.1


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "rest", [pytest.param({"valve.lap": 1e-3}, marks=pytest.mark.long), {"input.amplitude": 0.0}]
)
def test_record_without_any_motion_is_still_and_settled(rest: dict[str, object]) -> None:
    columns = _columns(SETTLED | rest)
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
def test_a_machine_that_cannot_exist_is_unusual(machine: dict[str, object]) -> None:
    columns = _columns(SETTLED | machine, coefficient=0.0)
    assert "unusual" in columns["verdict"][0]
    assert columns["status"][0] == "ok"


@pytest.mark.parametrize(
    ("values", "status"),
    [
        ({"record.step": 1e-3, "fluid.bulk_modulus": 1e11}, "diverged"),
        ({"actuator.load_stiffness": 0.0, "input.amplitude": 8.0, "input.period": 2.0}, "stroke_exceeded"),
    ],
)
def test_failed_run_has_its_failure_for_a_verdict_and_no_numbers(
    values: dict[str, object], status: str
) -> None:
    columns = _columns(values)
    assert columns["status"][0] == columns["verdict"][0] == status
    judged = [variable for variable in names.JUDGED if not variable.is_text]
    for name in ("detail_rms", "clipped_share", "pressure_variation", *(v.name for v in judged)):
        assert np.all(np.isnan(columns[name]))


def test_a_verdict_is_read_back_and_a_failure_is_no_doubt():
    assert {doubt.number for doubt in DOUBTS.values()} <= {variable.name for variable in names.COMPUTED}
    words = ["above_supply", "still"]
    assert [doubt.word for doubt in doubts_of(", ".join(words))] == words
    assert doubts_of("ok") == doubts_of("diverged") == doubts_of("") == ()


_WIDE = {"input.amplitude": 8.0}
_DRIFTING = {"input.period": 2.0}
_FREE = {"actuator.load_stiffness": 0.0, "input.amplitude": 8.0, "input.period": 2.0}


def _verdict(values: dict[str, Any], coefficient: float) -> str:
    return str(_columns(SETTLED | values, coefficient)["verdict"][0])


@pytest.mark.parametrize(
    ("word", "values", "turned", "coefficient"),
    [
        ("cavitating", _WIDE, {"input.amplitude": 2.0}, 4e-9),
        ("above_supply", _WIDE | {"supply.return_pressure": 3e6}, {"supply.pressure": 25e6}, 4e-9),
        ("unsettled", _DRIFTING, {"record.duration": 20.0}, 0.0),
        ("clipped", {"pressure_1_sensor.highest": 9e6}, {"pressure_1_sensor.highest": 25e6}, 4e-9),
        ("still", {"input.amplitude": 0.0}, {"input.amplitude": 5.0}, 4e-9),
        ("stroke_exceeded", _FREE, {"input.period": 0.5}, 4e-9),
        ("diverged", {"record.step": 1e-3, "fluid.bulk_modulus": 1e11}, {"record.step": 1e-5}, 4e-9),
    ],
)
def test_what_a_remedy_names_takes_the_verdict_away(
    word: str, values: dict[str, Any], turned: dict[str, Any], coefficient: float
) -> None:
    told = REMEDIES.get(word, "") or DOUBTS[word].remedy
    assert all(key in told for key in turned)
    assert word in _verdict(values, coefficient).split(", ")
    assert word not in _verdict(values | turned, coefficient).split(", ")


def test_remedies_name_keys_that_exist() -> None:
    told = " ".join([*(doubt.remedy for doubt in DOUBTS.values()), *REMEDIES.values()])
    known = {*parameter_names(), *(f"limits.{key}" for key in ExperimentConfig().limits.model_dump())}
    assert set(re.findall(r"\b(?!hydrofdi\.)[a-z_0-9]+\.[a-z_]+\b", told)) <= known
