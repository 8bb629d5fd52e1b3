"""A monitor that is killed at random moments says what an undisturbed one says, each thing once."""

import json

import pytest

from tests.monitor.soak import said, soak


@pytest.mark.parametrize(
    ("n_minute", "n_kill"), [(5, 5), pytest.param(60, 50, marks=pytest.mark.long)], ids=["short", "an hour"]
)
def test_killed_at_random_moments_it_says_what_the_undisturbed_one_says(n_minute, n_kill, tmp_path):
    assert soak(tmp_path, n_minute, n_kill) >= n_kill // 2
    records = [json.loads(line) for line in said(tmp_path / "log")]
    numbers = [record["number"] for record in records if record["line"] == "window"]
    events = {record["event"] for record in records if record["line"] == "event"}
    assert numbers == list(range(len(numbers)))
    assert {
        "alarm_raised",
        "gap",
        "duplicate",
        "time_ran_back",
        "stuck",
        "missing_samples",
        "malformed",
    } <= events
