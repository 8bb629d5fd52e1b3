"""Positions that do not follow the pressures."""

import numpy as np
import pytest
from indicators.signals import simulated

from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.measuring import measure
from records.measuring import P1, P2, POSITION, csv_of, one

RIG = """\
files: "*.csv"
sampling_frequency: 500 Hz
channels:
  chamber_1_pressure: {column: P1, unit: Pa}
  chamber_2_pressure: {column: P2, unit: Pa}
  piston_position: {column: x, unit: m}
  input_voltage: {column: u, unit: V}
"""


def recorded(folder, position_of=lambda x: x, pressure_of=lambda p: p):
    """A simulated record with another position and other pressures, read from a file."""
    run = simulated(leaks=np.array([1e-9]), moduli=np.array([551e6]))
    p1, p2, x, u = (run[channel][0] for channel in (P1, P2, POSITION, "input_voltage"))
    columns = ("P1", pressure_of(p1)), ("P2", pressure_of(p2)), ("x", position_of(x)), ("u", u)
    return one(folder, RIG, run_csv=csv_of(*columns))


@pytest.mark.parametrize("share", [0.0, 0.4])
@pytest.mark.parametrize("name", ["weak_rls", "flow_balance", "adaptive_observer"])
def test_a_stuck_position_gives_no_leakage(tmp_path, share, name):
    batch = recorded(
        tmp_path, lambda x: np.where(np.arange(x.size) < share * x.size, x, x[int(share * x.size)])
    )
    found = measure(batch, make_indicators({name: {"spool": "command"}, "dwt": {"channel": str(P1)}}))
    assert "piston_position does not change for" in found.obstacles[name][0]
    assert np.isnan(found.values[f"{name}.leakage"]).all()
    assert found.obstacles["dwt"] == (None,)


def test_a_position_that_moves_or_rests_with_the_pressures_is_measured(tmp_path):
    coarse = recorded(tmp_path, lambda x: np.round(x, 3))
    held = recorded(tmp_path, lambda x: np.full(x.size, 0.01), lambda p: p[0] + 1e-3 * (p - p[0]))
    for batch in (coarse, held):
        assert not any(remark.is_unusable for remark in batch.remarks[0])
