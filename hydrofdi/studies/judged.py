"""Evaluation of a stored study by the rules of its experiment."""

from __future__ import annotations

from hydrofdi.config.study.detection import DetectionConfig
from hydrofdi.store import ExperimentData
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.judgement import Detection
from hydrofdi.studies.reading import read_study
from hydrofdi.studies.rules import Rules, ThresholdKind


def judge_study(data: ExperimentData) -> tuple[Detection, ...]:
    """Evaluate every score of every design of a stored study.

    Raises
    ------
    ReportError
        The experiment has no study, or its file does not contain the runs of its study.
    """
    rules = rules_of(data.experiment.detection)
    return tuple(detect(design.records, design.scores, rules) for design in read_study(data))


def rules_of(asked: DetectionConfig) -> Rules:
    """Rules that an experiment requests."""
    threshold = ThresholdKind(asked.threshold)
    return Rules(asked.false_alarm_rate, asked.confidence, asked.probability, threshold)
