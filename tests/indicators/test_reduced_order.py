"""Reduced order: the residual of simulated runs, and what an adaptive threshold buys and costs."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.records import Channel
from indicators.observed import LEAKS, MODULI, simulated
from indicators.signals import P1, P2, batch, measured

SEALED, SMALL, LARGE = 0.0, 4e-10, 4e-9


@pytest.fixture(scope="module")
def runs():
    return simulated("record.duration=6 s")


@pytest.fixture(scope="module")
def uncertain():
    """Ten actuators unlike their data sheet, each sealed, with a small and with a large leak."""
    draw = np.random.default_rng(3)
    batches = []
    for gain, supply in zip(draw.uniform(-1.0, 1.0, 10), draw.uniform(-1.0, 1.0, 10), strict=True):
        settings = [
            "record.duration=6 s", f"valve.flow_gain={0.0292 * (1 + 0.025 * gain)} m^1.5/kg^0.5",
            f"supply.pressure={17.2 * (1 + 0.045 * supply)} MPa",
        ]  # fmt: skip
        batches.append(simulated(*settings, leaks=[SEALED, SMALL, LARGE], moduli=[551e6] * 3))
    return batch({each: np.concatenate([one[each] for one in batches]) for each in batches[0].channels})


def measured_by(records, **options):
    """Output → numbers."""
    values, obstacles = measured(records, "reduced_order", **options)
    assert obstacles == (None,) * records.n_record
    return values


@pytest.mark.parametrize("options", [{}, {"spool": "command"}, {"supply": "nominal"}])
def test_the_residual_of_a_known_actuator_is_its_leakage(runs, options):
    nominal = np.flatnonzero(MODULI == 551e6)
    values = measured_by(runs.rows(nominal.tolist()), **options)
    np.testing.assert_allclose(values["residual"], np.sqrt(8e6) * LEAKS[nominal], rtol=0.03, atol=1e-7)
    np.testing.assert_allclose(values["exceedance"], values["residual"] - values["bound"], rtol=1e-9)


def test_an_adaptive_threshold_lowers_false_alarms_and_loses_small_leaks(uncertain):
    """Fixed: zero, as a nominal actuator has it. Adaptive: what the bounds allow."""
    values = measured_by(uncertain, supply="nominal")
    fixed, adaptive = ((values[name] > 0.0).reshape(10, 3) for name in ("residual", "exceedance"))
    assert fixed[:, 0].mean() > 0.3
    assert adaptive[:, 0].mean() == 0.0
    assert fixed[:, 1].mean() > adaptive[:, 1].mean() + 0.2
    assert fixed[:, 2].all()
    assert adaptive[:, 2].all()


def test_the_bound_knows_how_the_supply_is_known(runs):
    supply = np.full_like(runs[P1], 17.2e6)
    with_supply = replace(runs, channels={**runs.channels, Channel.SUPPLY_PRESSURE: supply})
    bounds = [measured_by(with_supply, supply=each)["bound"] for each in ("measured", "sum", "nominal")]
    assert (bounds[0] < bounds[1]).all()
    assert (bounds[1] < bounds[2]).all()
    given = measured_by(with_supply, supply="measured", supply_bound=0.05)["bound"]
    np.testing.assert_allclose(given, bounds[2], rtol=0.05)


def test_a_valve_that_never_opens_and_pressures_that_are_equal_tell_nothing(runs):
    sentence = "no window has an open valve, a pressure difference and all samples"
    assert measured(runs, "reduced_order", least_opening="1 mm")[1][0] == sentence
    equal = replace(runs, channels={**runs.channels, P2: runs[P1]})
    values, obstacles = measured(equal, "reduced_order")
    assert obstacles[0] == sentence
    assert np.isnan(values["residual"]).all()
