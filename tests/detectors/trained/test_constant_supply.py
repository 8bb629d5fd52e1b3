"""A supply pressure that never changes is sound where healthy ones never did, and stuck where they did."""

import numpy as np
import pytest

from hydrofdi.detectors.trained.judging import Judge
from hydrofdi.detectors.trained.measuring import channel_facts, learned_range
from hydrofdi.records import Channel
from tests.detectors.trained.made import FREQUENCY, detector, signals
from tests.records.streams.plain import make_windower, windows_of

PS = Channel.SUPPLY_PRESSURE
CHANNELS = tuple(sorted({PS, *detector("flow_balance", direction="both").channels}))


def windows(seed, is_constant):
    samples = signals(seed, 5000)
    if is_constant:
        samples[PS] = np.full(5000, 17e6)
    windower = make_windower("time", 1000, channels=CHANNELS, sampling_frequency=FREQUENCY)
    return windows_of(np.arange(5000) / FREQUENCY, samples, windower)


def trained(is_constant):
    healthy = windows(1, is_constant)
    ranges = {
        each: learned_range(each, channel_facts(np.stack([w.channels[each] for w in healthy])))
        for each in CHANNELS
    }
    more = {"channels": CHANNELS, "ranges": ranges}
    return Judge(detector("flow_balance", direction="both").model_copy(update=more))


@pytest.mark.parametrize(("was_constant", "is_constant"), [(True, True), (False, False)])
def test_it_is_judged_where_healthy_windows_were_alike(was_constant, is_constant):
    faults = [verdict.fault for verdict in trained(was_constant).judge(windows(2, is_constant))]
    assert not [fault for fault in faults if fault is not None and fault.kind != "no_number"]


def test_it_is_stuck_where_healthy_windows_changed():
    (fault,) = {verdict.fault for verdict in trained(False).judge(windows(2, True))}
    assert (fault.kind, fault.message) == (
        "stuck",
        "supply_pressure is constant, but varies in healthy windows",
    )
