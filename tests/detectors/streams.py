"""Streams of scores whose law is known."""

import numpy as np
from scipy.signal import lfilter


def autoregressive(seed, n_stream, n_time, memory, between=0.0):
    """Scores of unit variance with correlation `memory` from one to the next, and offsets of streams."""
    draw = np.random.default_rng(seed)
    noise = draw.standard_normal((n_stream, n_time + 100))
    scores = lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], noise, axis=1)[:, 100:]
    return scores + between * draw.standard_normal((n_stream, 1))


def true_mean_time(chart, limit, scores, interval):
    """Mean time between false alarms over one long operation, by counting."""
    return scores.size * interval / max(int(np.sum(chart.follow(scores.reshape(1, -1), limit) >= limit)), 0.3)
