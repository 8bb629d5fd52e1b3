"""Hum is a steady line of the mains; a hydraulic mode next to it is not."""

import numpy as np
import pytest

import hydrofdi
from hydrofdi.records import Channel
from hydrofdi.records.measured.defects import hum_share

RATE = 500.0


@pytest.fixture(scope="module", params=["2 s", "4 s"])
def pressure(request):
    """A noise-free record whose hydraulic mode is at 59.6 Hz."""
    run = hydrofdi.simulate(duration=request.param)
    (batch,) = run.record_source([Channel.CHAMBER_1_PRESSURE]).batches()
    return batch.channels[Channel.CHAMBER_1_PRESSURE][0]


def _hum(pressure, mains):
    """Rectified hum: the mains and two harmonics, an error of the frequency as in a real net."""
    time = np.arange(pressure.size) / RATE
    amplitudes = {1: 1.0, 2: 0.5, 3: 0.2}
    return sum(a * np.sin(2.0 * np.pi * k * (mains + 0.02) * time + k) for k, a in amplitudes.items())


@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_a_mode_that_decays_is_not_hum(pressure, mains):
    assert hum_share(pressure, RATE, mains) < 0.1


@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_hum_over_the_strokes_is_found(pressure, mains):
    assert hum_share(pressure + 5.0 * np.std(pressure) * _hum(pressure, mains), RATE, mains) > 0.5


def test_a_repeated_decaying_mode_at_the_very_frequency_is_not_hum():
    time = np.arange(4000) / RATE
    since = time % 0.5
    assert hum_share(np.exp(-since / 0.05) * np.sin(2.0 * np.pi * 50.0 * since), RATE, 50.0) < 0.1


def test_hum_that_clipping_hides_for_a_while_is_found():
    samples = _hum(np.zeros(3000), 60.0)
    samples[:400] = 0.0
    assert hum_share(samples, RATE, 60.0) > 0.5


def test_measuring_a_simulated_record_remarks_no_hum(pressure):
    assert hydrofdi.measure(pressure, sampling_frequency=RATE)["status"].tolist() == ["ok"]
