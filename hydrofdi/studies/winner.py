"""The winner of a stored study, as the settings of a detector."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from typing import Any

from hydrofdi.errors import ConfigError, NotStatedError, ReportError
from hydrofdi.evaluation.scores import Direction, comparable
from hydrofdi.records import Channel
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.names import MISSING, STATUS
from hydrofdi.studies.detecting import detector_settings, judge_study, winner
from hydrofdi.studies.reading import within
from hydrofdi.studies.records import found_from

_log = logging.getLogger(__name__)


_MOST_NAMED = 5


def winner_settings(stored: ExperimentData, sensors: Sequence[str]) -> dict[str, Any]:
    """Settings of the winner of a study that needs no more than these sensors; all if none are named."""
    missing = int((stored.columns[STATUS].astype(str) == MISSING).sum())
    if missing:
        raise ReportError(
            f"{stored.path}: {counted(missing, 'run')} missing; sweep again to compute the rest"
        )
    try:
        channels = [Channel(name.strip()) for each in sensors for name in each.split(",")]
    except ValueError as error:
        known = ", ".join(channel.symbol for channel in Channel)
        raise ConfigError(f"sensors: {error}; known are {known}") from None
    detection = judge_study(stored)[0]
    best = winner(detection, channels)
    with_these = f" with {', '.join(each.symbol for each in channels)}" if channels else ""
    if channels and not any(within(each.scored, channels) for each in detection.judgements):
        raise ConfigError(f"sensors: the study has no score{with_these} alone")
    if best is None:
        rules = detection.rules
        n_fit, n_test = rules.records_for_threshold(Direction.BOTH), rules.records_for_false_alarms
        raise NotStatedError(
            f"{stored.path}: no score{with_these} is known to keep its false-alarm rate; to know it takes"
            f" study.healthy: {{fit: {n_fit}, test: {n_test}, shift: {n_test}}} or more, and to keep it a"
            " study.population that includes the shifts that are normal",
            n_test,
        )
    better = [
        each.scored.name
        for each in detection.judgements
        if each.keeps_its_rate is None
        and comparable(found_from(each)) < comparable(found_from(best))
        and within(each.scored, channels)
    ]
    if better:
        _log.warning(
            f"{best.scored.name} is the best score known to keep its false-alarm rate; undecided, as too few"
            f" records test it, but better: {', '.join(better[:_MOST_NAMED])}"
        )
    if not found_from(best) < math.inf:
        _log.warning(f"{best.scored.name} finds none of the tested leaks nine times in ten")
    study, made_by = stored.experiment.study, best.scored.made_by
    numbers = [best.scored.name] if made_by is None else [*made_by.of, *made_by.by]
    is_drawn = study is not None and "wavelet.phase" in study.population.per_record
    if is_drawn and any(number.startswith("dwt.") for number in numbers):
        _log.warning(
            f"{best.scored.name}: the study draws the start phase of the wavelet, windows of a detector all"
            " start at one, so its rates may differ; wavelet: {phase: 0} in the study makes them equal"
        )
    return detector_settings(stored.experiment, best, detection.rules)
