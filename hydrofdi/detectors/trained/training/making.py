"""Training of a detector: from healthy records to a detector file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from hydrofdi.detectors.healthy_scale import healthy_scale
from hydrofdi.detectors.trained.configuration import ChartConfig, DetectorConfig
from hydrofdi.detectors.trained.file import Basis, DetectorFile, Made, Scale
from hydrofdi.detectors.trained.measuring import feature_of
from hydrofdi.detectors.trained.training.chart_limits import chart_in_full, chart_limit
from hydrofdi.detectors.trained.training.learned import Learned
from hydrofdi.detectors.trained.training.learning import learn
from hydrofdi.detectors.trained.training.limits import limits_of
from hydrofdi.evaluation.direction import Direction
from hydrofdi.records import RecordSource


def train(healthy: RecordSource, config: DetectorConfig, sources: Sequence[str], made: Made) -> DetectorFile:
    """Train a detector on healthy records.

    Parameters
    ----------
    healthy : RecordSource
        Only healthy records; the groups of their batches identify dependent records.
    config : DetectorConfig
        Configuration; the file contains it with all defaults.
    sources : sequence of str
        Names of the sources.
    made : Made

    Raises
    ------
    ConfigError
        The indicator has no such output, or no direction is stated and the output does not declare one.
    DataError
        The records lack a channel, or differ in sampling or length.
    NotStatedError
        There are too few records for the false-alarm rate; the message states how many are needed.
    """
    direction, confidence = feature_of(config).direction(config.direction), config.confidence
    chart = None if config.chart is None else chart_in_full(config.chart, direction)
    learned = learn(healthy, config)
    limits = limits_of(learned, config, direction)
    scale = healthy_scale(learned.scores)
    lowest, highest = float(np.nanmin(learned.scores)), float(np.nanmax(learned.scores))
    healthy_score = Scale(centre=scale.centre, spread=scale.spread, range=(lowest, highest))
    return DetectorFile(
        made=made,
        config=_in_full(config, learned, direction, chart),
        indicator_version=learned.feature.indicator.version,
        unit=learned.unit,
        channels=learned.channels,
        sampling_frequency=learned.sampling_frequency,
        n_sample=learned.n_sample,
        basis=_basis(learned, sources),
        healthy=healthy_score,
        limits=limits,
        chart=None if chart is None else chart_limit(learned, chart, healthy_score, direction, confidence),
        ranges=dict(learned.ranges),
        positive=learned.positive,
        fits=learned.fits,
        drive=learned.drive,
    )


def _in_full(
    config: DetectorConfig, learned: Learned, direction: Direction, chart: ChartConfig | None
) -> DetectorConfig:
    """Configuration with all defaults filled in."""
    feature, window = learned.feature, config.window
    if learned.n_sample:
        every = window.every or (learned.duration if window.by == "time" else None)
        window = window.model_copy(update={"duration": learned.duration, "every": every})
    return config.model_copy(
        update={
            "options": feature.indicator.options.model_dump(mode="json"),
            "output": feature.described.name,
            "direction": direction,
            "window": window,
            "chart": chart,
        }
    )


def _basis(learned: Learned, sources: Sequence[str]) -> Basis:
    populations: Counter[str] = Counter()
    for each in learned.records:
        populations[each.label] += each.line.chosen.size
    del populations[""]
    return Basis(
        sources=tuple(sources),
        n_record=len(learned.records),
        n_window=learned.scores.size,
        n_group=len(set(learned.groups)) if learned.has_groups else 0,
        populations=dict(sorted(populations.items())),
        not_judged=dict(learned.not_judged),
        impossible=learned.impossible,
        drive_period=learned.drive_period,
    )
