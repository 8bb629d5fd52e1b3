"""The period of a drive, found from u."""

import numpy as np
import pytest

from hydrofdi.records import Channel, RecordBatch
from hydrofdi.records.stuck import found_period

TIME = np.arange(20_000) / 1e3
DRAWN = np.random.default_rng(4)
SQUARE = np.sign(np.sin(np.pi * TIME + 0.3))


def of(u, **known):
    return found_period(RecordBatch({Channel.INPUT_VOLTAGE: u[None]}, 1e3, ("a",), **known))


@pytest.mark.parametrize(
    ("u", "period"),
    [
        (SQUARE, 2.0),
        (SQUARE + 0.1 * DRAWN.normal(size=TIME.size), 2.0),
        (3.0 * np.sin(2.0 * np.pi * TIME / 0.8), 0.8),
        (np.repeat(DRAWN.uniform(-1.0, 1.0, 40), 500), None),
        (np.repeat(DRAWN.choice([-1.0, 1.0], 40), 500), None),
        (DRAWN.normal(size=TIME.size), None),
        (np.sin(0.5 * np.pi * TIME**1.5), None),
        (SQUARE[:4000], None),
        (np.zeros(TIME.size), None),
        (np.where(TIME > 1.0, SQUARE, np.nan), None),
    ],
    ids=["square", "noisy", "sine", "steps", "telegraph", "noise", "chirp", "two periods", "still", "holes"],
)  # fmt: skip
def test_a_period_is_found_where_u_repeats(u, period):
    assert of(u) == period


def test_a_known_period_is_kept():
    assert of(SQUARE, drive_period=5.0) == 5.0
