"""Laws of the hysteresis between voltage and spool."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hydrofdi.config import RunParameters
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.drive import Drive, Spools

WIDTH, AMPLITUDE = 0.2, 1.0
SINE: dict[str, Any] = {"input.shape": "sine", "input.amplitude": AMPLITUDE}
QUICK_SPOOL = {"valve.natural_frequency": 500.0, "valve.damping_ratio": 1.0}
GAIN = RunParameters().valve.spool_gain


def _loop(period: float, **valve: float) -> tuple[np.ndarray, np.ndarray]:
    """Voltage and what the spool makes of it [V], over the second of two periods."""
    values = SINE | QUICK_SPOOL | {f"valve.{name}": value for name, value in valve.items()}
    run = RunParameters().with_values(values | {"input.period": period, "record.duration": 2 * period})
    n_step = round(period / run.record.step)
    spools = Spools([Drive.of(run)], run.record)
    for first in (0, n_step):
        voltage, stages = spools.advance(first, n_step)
        loop = voltage[:, 0].copy(), stages[:, 0, 0] / GAIN
    return loop


@pytest.mark.parametrize("period", [2.0, 8.0])
def test_loop_closes_and_is_as_wide_as_configured_at_any_rate(period: float) -> None:
    """Up and down branch, a quarter of a period after the turns: ∓h/2 about the voltage; area h (2U − h)."""
    voltage, spool = _loop(period, hysteresis=WIDTH)
    n = voltage.size
    assert spool[0] == pytest.approx(-WIDTH / 2, abs=0.01 * 8 / period)
    assert spool[n // 2] == pytest.approx(WIDTH / 2, abs=0.01 * 8 / period)
    assert spool[-1] == pytest.approx(spool[0], abs=0.005)
    assert spool.max() == pytest.approx(AMPLITUDE - WIDTH / 2, rel=1e-3)
    area = abs(np.trapezoid(np.append(spool, spool[0]), np.append(voltage, voltage[0])))
    assert area == pytest.approx(2 * WIDTH * (AMPLITUDE - WIDTH / 2), rel=0.02 * 8 / period)


def test_voltage_that_turns_back_by_less_than_the_width_leaves_the_spool_alone() -> None:
    _, spool = _loop(2.0, hysteresis=2.01 * AMPLITUDE)
    assert not spool.any()


def test_hysteresis_of_no_width_is_none() -> None:
    np.testing.assert_allclose(_loop(2.0, hysteresis=1e-12)[1], _loop(2.0)[1], atol=1e-11)


def test_closed_loop_swings_about_a_position_that_it_would_reach() -> None:
    """An integral part and a play cannot agree: the voltage keeps crossing the whole width."""
    values = {
        "control.law": "pi", "control.amplitude": 5e-3, "control.integral_gain": 400.0,
        "input.period": 40.0, "record.duration": 10.0,
    }  # fmt: skip
    plain, loose = (RunParameters().with_values(values | {"valve.hysteresis": w}) for w in (0.0, WIDTH))
    batch = simulate_batch([plain, loose], [2e-9, 2e-9])
    late = np.ptp(batch.input_voltage[:, batch.time > 6.0], axis=1)
    assert late[0] < 0.1 * WIDTH
    assert late[1] > WIDTH
