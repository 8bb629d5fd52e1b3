"""Indicators of measured records, where these are present; pressures and positions are in counts."""

import numpy as np

from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records import Channel
from hydrofdi.records.source import measured_source
from tests.conftest import needs_vtnsi
from tests.records.test_vtnsi import description

pytestmark = needs_vtnsi

P1, P2 = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE


def records(folder, more=""):
    path = description(folder)
    path.write_text(path.read_text(encoding="utf-8") + more, encoding="utf-8")
    (batch,) = measured_source(path).batches()
    return batch


def test_the_driven_side_rings_at_the_end_stop_and_the_side_that_is_clipped_at_zero_does_not(tmp_path):
    impacts = records(tmp_path, "segment: {part: impact, length: 0.6 s}\n")
    forward = np.array([group.endswith("+") for group in impacts.groups])
    sides = {"first": {"kind": "ring_down"}, "second": {"kind": "ring_down", "channel": P2.value}}
    values = measure(impacts, make_indicators(sides)).values
    for name, is_driven in (("first", forward), ("second", ~forward)):
        frequency, damping = (values[f"{name}.{key}"][is_driven] for key in ("frequency", "damping_ratio"))
        assert ((frequency > 20.0) & (frequency < 27.0)).mean() > 0.95
        assert 22.0 < np.median(frequency) < 23.5
        assert 0.25 < np.median(damping) < 0.32
        assert (values[f"{name}.steps"][~is_driven] == 0.0).mean() > 0.95


def test_pressures_in_the_hold_fall_slowly_and_what_needs_a_scale_or_a_valve_is_refused(tmp_path):
    strokes = records(tmp_path)
    names = ["post_step_ac", "cross_correlation", "pressure_statistics", "pressure_decay", "flow_balance"]
    measures = measure(strokes, make_indicators(names))
    driven = np.where(strokes[P1][:, -1] > strokes[P2][:, -1], 0, 1)
    rates = np.stack([measures.values[f"pressure_decay.chamber_{number}"] for number in (1, 2)])
    held, returned = rates[driven, np.arange(70)], rates[1 - driven, np.arange(70)]
    assert ((held > -250.0) & (held < -100.0)).all()
    assert (np.abs(returned) < 0.2 * np.abs(held)).all()
    assert (measures.values["pressure_decay.duration"] > 1.5).all()
    assert (measures.values["cross_correlation.coefficient"] < -0.9).all()
    assert all("has no spool_position" in reason for reason in measures.obstacles.pop("flow_balance"))
    assert set().union(*measures.obstacles.values()) == {None}
    balanced = measure(strokes, make_indicators({"flow_balance": {"spool": "command"}}))
    assert set(balanced.obstacles["flow_balance"]) == {"has no input_voltage"}
