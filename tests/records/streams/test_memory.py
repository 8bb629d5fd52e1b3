import tracemalloc

import numpy as np
import pytest

from hydrofdi.records.batch import Channel
from hydrofdi.records.streams import Chunk, EvenStream
from tests.records.streams.plain import make_windower

P1, U = Channel.CHAMBER_1_PRESSURE, Channel.INPUT_VOLTAGE
FREQUENCY, N_CHUNK = 1000.0, 50_000

WINDOWINGS = {
    "side by side": {"by": "time", "n_sample": 1000},
    "sliding": {"by": "time", "n_sample": 1000, "n_every": 400},
    "apart": {"by": "time", "n_sample": 100, "n_every": 1_000_000},
    "cycles": {"by": "cycle", "n_sample": 1000, "drive": (-1.0, 1.0)},
    "cycles that never end": {"by": "cycle", "n_sample": 1000, "drive": (-9.0, -8.9)},
}


@pytest.mark.parametrize("windowing", WINDOWINGS.values(), ids=WINDOWINGS)
def test_memory_stays_as_it_is_over_ten_million_samples(windowing):
    stream = EvenStream(FREQUENCY, (P1, U))
    windower = make_windower(**windowing, channels=(P1, U), sampling_frequency=FREQUENCY)
    state, held, in_use = stream.start(), windower.start(), []
    one_window = 3 * 8 * windowing["n_sample"]
    tick = np.arange(N_CHUNK) / FREQUENCY
    wave = np.sin(2.0 * np.pi * 0.93 * tick)
    tracemalloc.start()
    for count in range(200):
        gap = 10.0 * (count // 7)
        chunk = Chunk(gap + count * N_CHUNK / FREQUENCY + tick, {P1: 1e6 * wave, U: wave})
        state, pieces, _ = stream.step(state, chunk)
        for piece in pieces:
            held = windower.step(held, piece)[0]
        del chunk, pieces, piece
        for stored in (state, held):
            assert all(array.base is None for array in stored.values())
            assert sum(array.nbytes for array in stored.values()) < one_window + 200
        in_use.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert max(in_use[10:]) < min(in_use[:10]) + 2 * one_window + 20_000
