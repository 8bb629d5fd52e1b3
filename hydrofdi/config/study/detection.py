"""The ``detection`` section: how indicators are judged as detectors."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from hydrofdi.config.study.online import OnlineConfig
from hydrofdi.records import Channel
from hydrofdi.settings.quantities import SI, Section


class ScoreConfig(Section):
    """A score computed from measured numbers."""

    kind: Literal["mahalanobis", "one_class", "lda", "logistic", "compensated", "largest_change"]
    """``mahalanobis`` and ``one_class`` are fitted to healthy fit records, ``lda`` and ``logistic`` to
    healthy and leaking ones. ``compensated``: a number minus its expected value, from its regression on
    ``by`` in healthy fit records. ``largest_change``: the largest fall below the mean of healthy fit records,
    as a share of it; of ``dwt.d1`` … ``dwt.d5`` the rule of the paper."""

    of: list[str] = Field(min_length=1)
    """Inputs: labels of indicators, or single numbers such as ``ring_down.damping_ratio``."""

    by: list[str] = Field(default_factory=list)
    """Numbers that ``compensated`` regresses on."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the kind, which may also be given next to the other keys: ``shrinkage`` (0 to 1) of
    ``mahalanobis``; ``outside`` (share of fit records, above 0) and ``width`` of ``one_class``; ``seed`` of
    ``logistic``."""

    @model_validator(mode="after")
    def _compensated_alone_regresses(self) -> Self:
        if (self.kind == "compensated") != bool(self.by):
            needs = "has no use for 'by'" if self.by else "needs 'by': numbers to regress on"
            raise ValueError(f"{self.kind} {needs}")
        return self


class ScoresConfig(Section):
    """The ``scores`` of a file of indicators."""

    scores: dict[str, ScoreConfig]


class DetectionConfig(Section):
    """Requirements on detectors, and the detectors that are judged."""

    false_alarm_rate: Annotated[float, SI("1", above=0, most=0.5)] = 0.01
    """False-alarm rate for which thresholds are set on healthy fit records [-]."""

    confidence: Annotated[float, SI("1", least=0.5, most=0.9999)] = 0.95
    """Confidence of intervals and bounds [-]."""

    probability: Annotated[float, SI("1", least=0.5, most=0.9999)] = 0.9
    """Probability with which a leak should be found: 90 % gives q90 and, with the confidence, q90/95 [-]."""

    threshold: Literal["quantile", "tolerance", "tail"] = "quantile"
    """``quantile``: the rate on average over fit sets. ``tolerance``: at most the rate, with ``confidence``.
    ``tail``: a generalised Pareto model of the largest scores, for rates of 0.1 % and less."""

    indicators: list[str] = Field(default_factory=list)
    """Labels of the indicators to judge; by default all that are measured. If the file has no ``indicators``,
    these are also the ones measured, in any form that ``indicators`` accepts; ``all`` then means all cheap
    ones."""

    sensors: list[Channel] = Field(default_factory=list)
    """Channels of the machine, by symbol or name, such as ``[P1, P2, x, u]``; scores that need others are
    left out. By default every channel may be used."""

    scores: dict[str, ScoreConfig] = Field(default_factory=dict)
    """Label → score computed from several numbers, or one compensated number. A label has letters, digits,
    ``_`` and ``-``, begins with a letter, has at most 64 characters, and is not the label of an indicator."""

    usual_scores: bool = False
    """Whether to add, for each set of sensors that an indicator needs, a score of all numbers from these
    sensors: ``mahalanobis``, and ``lda`` if there are leaking fit records; also ``largest_change`` of
    ``dwt.d1`` … ``dwt.d5`` if they are measured."""

    online: OnlineConfig | None = None
    """Control charts on the traces of the records: false alarms over time, and the delay after the onset of a
    leak."""

    @field_validator("sensors")
    @classmethod
    def _each_once(cls, given: list[Channel]) -> list[Channel]:
        return list(dict.fromkeys(given))
