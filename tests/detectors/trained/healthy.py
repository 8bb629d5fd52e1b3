"""Healthy records whose score is known: the mean pressure of a window is a normal number of our choice."""

from itertools import groupby

import numpy as np
from scipy.signal import lfilter

from hydrofdi.records import Channel, RecordBatch

N_SAMPLE = 4
FREQUENCY = 4.0
PATTERN = np.array([1.0, -1.0, -1.0, 1.0])


class Records:
    """Records of windows whose mean pressures are given; rows are records.

    A source of records, as training reads them.
    """

    name, data_sheet = "made", {}

    def __init__(self, means, groups=(), labels=None, **more):
        self.means, self.groups, self.labels, self.more = [*means], tuple(groups), labels, more

    def batches(self, *, labels=False):
        """Records of equal length side by side, as far as they follow each other."""
        first = 0
        for _, alike in groupby(self.means, key=len):
            means = np.array([*alike], dtype=float)
            rows = slice(first, first + len(means))
            samples = (means[:, :, None] + PATTERN).reshape(len(means), -1)
            first = rows.stop
            yield RecordBatch(
                {Channel.CHAMBER_1_PRESSURE: samples} | self.more.get("channels", {}),
                self.more.get("sampling_frequency", FREQUENCY),
                tuple(f"record {row}" for row in range(rows.start, rows.stop)),
                ("made",) * len(means),
                self.groups[rows],
                labels=tuple(self.labels[rows]) if labels and self.labels else None,
            )


def autoregressive(draw, shape, correlation):
    """Standard normal numbers, shape (n_record, n_window), each correlated with the one before it."""
    noise = draw.standard_normal((shape[0], shape[1] + 100))
    return lfilter([np.sqrt(1.0 - correlation**2)], [1.0, -correlation], noise, axis=1)[:, 100:]


def grouped(draw, n_group, n_window, correlation):
    """Standard normal numbers, shape (n_group, n_window), that share a part within a group."""
    own, common = draw.standard_normal((n_group, n_window)), draw.standard_normal((n_group, 1))
    return np.sqrt(correlation) * common + np.sqrt(1 - correlation) * own
