"""Healthy records → a trained detector."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from hydrofdi.detectors.healthy_scale import healthy_scale
from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.detectors.trained.file import Basis, DetectorFile, Made, Scale
from hydrofdi.detectors.trained.learned import Learned
from hydrofdi.detectors.trained.learning import learn
from hydrofdi.detectors.trained.setting_limits import limits_of
from hydrofdi.records import RecordSource


def train(healthy: RecordSource, config: DetectorConfig, sources: Sequence[str], made: Made) -> DetectorFile:
    """A detector from healthy records.

    Parameters
    ----------
    healthy : RecordSource
        Healthy records alone; the groups of their batches say what depends on each other.
    config : DetectorConfig
        What is left out there is written out in the file.
    sources : sequence of str
        What a person calls the sources.
    made : Made

    Raises
    ------
    ConfigError
        The indicator has no such output, or no direction of its own where none is stated.
    DataError
        The records lack a channel, or differ in sampling or length.
    NotStatedError
        There are too few records for the rate of false alarms; it tells how many are needed.
    """
    learned = learn(healthy, config)
    direction = learned.feature.direction(config.direction)
    scale = healthy_scale(learned.scores)
    return DetectorFile(
        made=made,
        config=_in_full(config, learned),
        indicator_version=learned.feature.indicator.version,
        unit=learned.unit,
        channels=learned.channels,
        sampling_frequency=learned.sampling_frequency,
        n_sample=learned.n_sample,
        basis=_basis(learned, sources),
        healthy=Scale(centre=scale.centre, spread=scale.spread),
        limits=limits_of(learned, config, direction),
        ranges=dict(learned.ranges),
        drive=learned.drive,
    )


def _in_full(config: DetectorConfig, learned: Learned) -> DetectorConfig:
    """With all that was left out."""
    feature, window = learned.feature, config.window
    if learned.n_sample:
        duration = learned.n_sample / learned.sampling_frequency
        window = window.model_copy(update={"duration": duration, "every": window.every or duration})
    return config.model_copy(
        update={
            "options": feature.indicator.options.model_dump(mode="json"),
            "output": feature.described.name,
            "direction": feature.direction(config.direction),
            "window": window,
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
    )
