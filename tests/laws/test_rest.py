"""A machine at rest: its decays end in zeros, not in subnormal numbers, with which processors are slow."""

from __future__ import annotations

import ctypes
import platform
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_option_combinations import CHOICES

from hydrofdi.config import RunParameters, load_experiment
from hydrofdi.physics.equation import NEGLIGIBLE, settled
from hydrofdi.simulation import batch, drive
from hydrofdi.simulation.batch import simulate_batch

LEAST_NORMAL = np.finfo(float).tiny
UNDERFLOW = {"x86_64": 0x10, "aarch64": 0x08}.get(platform.machine(), 0) if sys.platform == "linux" else 0
"""The processor's mark of a result that became subnormal, by the C library's number."""

HELD = {"input.period": 10.0}
PRESSED = {"control.amplitude": 0.5, "actuator.load_stiffness": 1e7, "valve.natural_frequency": 225.0}
"""A reference out of reach, so that the controller stays at its limit and the spool comes to rest."""
DRAINED = {
    "input.amplitude": 0.0, "control.amplitude": 0.0,
    "supply.return_pressure": 0.0, "leakage.external_coefficient": 1e-10,
}  # fmt: skip
SIGNALS = (
    "spool_position", "piston_position", "piston_velocity", "chamber_1_pressure", "chamber_2_pressure",
    "valve_supply_pressure", "bristle_deflection", "internal_leakage_flow",
)  # fmt: skip


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """What becomes subnormal in the kernels, by name."""
    names: set[str] = set()
    monkeypatch.setattr(batch, "advance_lanes", watched(batch.advance_lanes, names))
    monkeypatch.setattr(drive, "advance_spools", watched(drive.advance_spools, names))
    return names


def watched(kernel: Callable[..., None], names: set[str]) -> Callable[..., None]:
    """A kernel that notes the subnormal fields of the record it has advanced, and whether it underflowed."""

    def advance(record: np.ndarray, *others: Any) -> None:
        if UNDERFLOW:
            ctypes.CDLL(None).feclearexcept(UNDERFLOW)
        kernel(record, *others)
        if UNDERFLOW and ctypes.CDLL(None).fetestexcept(UNDERFLOW):
            names.add("an operation")
        names.update(subnormal_fields(record))

    return advance


def subnormal_fields(record: np.ndarray) -> set[str]:
    fields = record.dtype.names or ()
    own = {name for name in fields if is_subnormal(record[name])}
    return own.union(*(subnormal_fields(record[name]) for name in fields))


def is_subnormal(values: np.ndarray) -> bool:
    return values.dtype == float and bool(np.any((values != 0.0) & (np.abs(values) < LEAST_NORMAL)))


@pytest.fixture(scope="module")
def stopped(tmp_path_factory: pytest.TempPathFactory) -> RunParameters:
    """A valve that moves and is then closed."""
    file: Path = tmp_path_factory.mktemp("input") / "stop.csv"
    file.write_text("time [s], voltage [V]\n0, 2\n0.2, -1\n0.3, 0\n")
    return load_experiment(None, ["input.shape=csv", f"input.file={file}"]).nominal_parameters


@pytest.mark.parametrize("name", CHOICES)
def test_nothing_becomes_subnormal_at_rest(name: str, stopped: RunParameters, found: set[str]) -> None:
    values = CHOICES[name] | {"record.duration": 2.0}
    nominal = RunParameters().with_values(values)
    runs = [nominal.with_values(rest) for rest in (HELD, HELD | PRESSED, DRAINED)]
    if not nominal.control.is_closed:
        runs.append(stopped.with_values(values))
    trajectory = simulate_batch(runs, [3e-9] * len(runs))
    found.update(signal for signal in SIGNALS if is_subnormal(getattr(trajectory, signal)))
    assert not found
    assert [outcome.status for outcome in trajectory.outcomes] == ["ok"] * len(runs)


def test_a_closed_valve_comes_to_rest(stopped: RunParameters) -> None:
    opening = simulate_batch([stopped.with_values({"record.duration": 2.0})], [0.0]).spool_position[0]
    assert np.abs(opening).max() > 1e-5
    assert opening[-1] == 0.0


def test_only_what_is_negligible_settles() -> None:
    assert settled(0.99 * NEGLIGIBLE) == settled(-0.99 * NEGLIGIBLE) == 0.0
    assert settled(-NEGLIGIBLE) == -NEGLIGIBLE
    assert np.isnan(settled(np.nan))
