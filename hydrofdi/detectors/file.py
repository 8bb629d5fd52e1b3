"""Detector files: JSON that is validated strictly when read. Nothing in it is executed."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, ValidationError

from hydrofdi.detectors.configuration import DetectorConfig, Feature, feature_of, unmakable
from hydrofdi.detectors.rules import score_kind
from hydrofdi.detectors.scores.contract import from_data
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.nominal_actuator import plant_constants, sheet_constants
from hydrofdi.records import Array, Channel
from hydrofdi.records.data_sheet import is_other
from hydrofdi.settings.files import dotted, known_keys
from hydrofdi.settings.messages import convert, describe_error, plain, readable_unit, shown_quantity
from hydrofdi.settings.quantities import Section

SCHEMA = "hydrofdi.detector"

MOST_BYTES = 2**24
"""Maximum size of a detector file [bytes]."""

_MOST_SHOWN = 200
_NUMBERS_PER_LINE = re.compile(r"\[\n\s+([-+\d.eE,\snul]+?)\n\s*\]")
"""A list of numbers, one per line; JSON strings cannot contain line breaks."""

Count = Annotated[int, Field(ge=0)]


def _ordered(ends: tuple[float, float]) -> tuple[float, float]:
    if ends[0] > ends[1]:
        raise ValueError("expected the lower value first")
    return ends


Range = Annotated[tuple[float, float], AfterValidator(_ordered)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]


class FileSection(Section):
    """A section of a detector file, of finite numbers."""

    model_config = ConfigDict(allow_inf_nan=False)


class Made(FileSection):
    """Origin of the file."""

    hydrofdi: str
    """Version of hydrofdi."""

    time: str
    """Time of training, in UTC."""

    command: str = ""
    """Command line."""


class Basis(FileSection):
    """Data behind the stated false-alarm rate."""

    sources: tuple[str, ...] = Field(min_length=1)
    """Sources of the healthy records."""

    n_record: int = Field(ge=1)
    """Number of healthy records."""

    n_window: int = Field(ge=1)
    """Number of non-overlapping windows that set the threshold."""

    n_group: Count
    """Number of independent groups, such as units or days; 0 if no groups were stated."""

    populations: dict[str, Count]
    """Label of healthy records → number of their windows; empty if there are no labels."""

    not_judged: dict[str, Count]
    """Kind of fault → number of healthy windows that were not used because of it."""

    fleet: str = ""
    """File and size of the fleet that limits of earlier versions rest on too."""

    impossible: dict[str, Count] = Field(default_factory=dict)
    """Output → number of healthy windows in which it is impossible, or does not fit."""

    likely: str = ""
    """If the data sheet does not fit: the constants that are likeliest wrong."""

    outlying: dict[str, Count] = Field(default_factory=dict)
    """Healthy record → number of its windows more than eight healthy spreads from the median, where a leak
    moves them, if most of them are."""

    drive_period: float | None = Field(None, gt=0.0)
    """Period of the drive of the first healthy record [s]; null if none is known or found."""


class Scale(FileSection):
    """Median, spread and range of the healthy score, in the unit of the output."""

    centre: float
    """Median."""

    spread: float = Field(gt=0.0)
    """Interquartile range over 1.349."""

    range: Range | None = None
    """Lowest and highest healthy score; null if the file does not state them."""


class Limits(FileSection):
    """Limits of the score, in the unit of the output, and the false-alarm rate."""

    low: float | None
    """Lower limit: a score below it is an alarm; null if there is none."""

    high: float | None
    """Upper limit: a score above it is an alarm; null if there is none."""

    false_alarm_rate: float = Field(ge=1e-9, le=0.5)
    """Required fraction of healthy windows that raise an alarm."""

    interval: Annotated[tuple[Share, Share], AfterValidator(_ordered)]
    """Confidence interval of the true fraction."""

    confidence: float = Field(ge=0.5, le=0.9999)
    """Confidence level of the interval."""

    method: str
    """Method that set the limits."""

    allowance: float = Field(default=0.0, ge=0.0)
    """Part of the upper limit that allows for warmer oil, if its temperature is not known; not part of the
    interval."""

    interval_rests_on: Literal["windows", "records", "groups", "fleet"]
    """``windows``: windows are assumed independent. ``records``, ``groups``: cross-validation, in which each
    record or group is tested with the limits of the others. ``fleet``: normal scores of a machine like those
    of a fleet."""


class ChartLimit(FileSection):
    """Limit of the control chart."""

    limit: float = Field(gt=0.0)
    """Alarm when the statistic reaches it; the chart then restarts."""

    mean_time: float | None
    """Mean time between false alarms on healthy records [s]; null if there was no alarm."""

    interval: tuple[float, float | None]
    """Confidence interval of the mean time [s]; null if there is no upper bound."""

    hours: float
    """Hours of healthy operation in the training data."""

    rests_on: Literal["pieces", "records", "groups"] = "records"
    """Resampled units: groups, records, or pieces of records if there are few records."""


class TrainedScore(FileSection):
    """What a score of several numbers learned."""

    numbers: tuple[str, ...] = Field(min_length=1)
    """Numbers that it combines, in order."""

    rule: dict[str, Any]
    """Arrays and numbers of its rule."""

    n_healthy: Count
    n_faulty: Count
    """Windows that it was fitted to."""

    def fitted(self, kind: str) -> Any:
        """The trained rule."""
        rule: Any = from_data(score_kind(kind).Trained, self.rule, "score.rule")
        try:
            rule.score(np.ones((1, len(self.numbers))))
        except IndexError:
            raise ValueError(f"score.rule: is not one of {len(self.numbers)} numbers") from None
        return rule


class ChannelRange(FileSection):
    """Range of a channel in healthy windows, widened by a margin; a window outside it is novel."""

    low: Range
    """Range of the 1 % quantile."""

    high: Range
    """Range of the 99 % quantile."""

    activity: Range
    """Range of the RMS of differences between adjacent samples."""

    at_end: Share
    """Largest fraction of samples at the lowest or at the highest value; above it a window is clipped."""

    held: Share = 1.0
    """Largest fraction of samples that repeat the one before; above it a window is stuck."""

    rate: Share = 0.0
    """Fewest updates in a sampling period; below it a window is stuck. Less than 1 if the channel is held or
    interpolated."""


LIKE = "as of a hole or score", "as of a gap or leaky valve"
"""What the first of two alarms may come from, and the other."""

_HOLE = 0.8
"""Least share of K_i in a change of the whole flow by a hole: on 40 machines of unknown-plant 0.9 to 1.05
in most windows of 2 s, of a gap up to 0.7."""


class DetectorFile(FileSection):
    """A trained detector."""

    schema_name: Literal["hydrofdi.detector"] = Field(default="hydrofdi.detector", alias="schema")
    """Identifier of the schema."""

    version: Literal[2] = 2
    """Version of the schema."""

    units: str = "SI: s, Hz, m, V, Pa; scores in the unit below"
    """Units of all numbers in the file."""

    made: Made
    config: DetectorConfig
    """Complete configuration with all options, so that new defaults of hydrofdi have no effect."""

    assumed: tuple[str, ...] = ()
    """Plant constants that were left at their nominal values although the records are measured."""

    data_sheet: dict[str, Any] = Field(default_factory=dict)
    """Plant constants that the description of the healthy records states."""

    indicator_versions: dict[str, int]
    """Label → version of an indicator; a different version gives different values and is refused."""

    score: TrainedScore | None = None
    """What the score learned; null if the output is the score."""

    unit: str
    """SI unit of the score."""

    channels: tuple[Channel, ...]
    """Channels that a window needs."""

    sampling_frequency: float = Field(ge=1e-3, le=1e9)
    """[Hz]"""

    n_sample: int = Field(ge=2)
    """Samples per window."""

    basis: Basis
    healthy: Scale
    limits: Limits
    chart: ChartLimit | None = None
    fleet: Any = Field(default=None, exclude=True)
    """Spread over machines in files of earlier versions; has no effect."""

    ranges: dict[Channel, ChannelRange]
    """Healthy range of each channel."""

    conditions: dict[str, Range] = Field(default_factory=dict)
    """Oil temperature [K], estimated bulk modulus and supply pressure [Pa] → lowest and highest value of the
    healthy windows; a window far outside is novel."""

    positive: tuple[str, ...] = ()
    """Outputs that can only be positive, and are so in all healthy windows; in other windows without an alarm
    they make the window novel, the flow gain in any."""

    fits: dict[str, float] = Field(default_factory=dict)
    """Output that states how well the model explains a window → largest value without a doubt: that of the
    indicator, or the largest of the healthy windows if that is larger."""

    drive: Range | None = None
    """Lowest and highest value of the channel whose edges start cycles."""

    @cached_property
    def feature(self) -> Feature:
        """What is measured and judged."""
        feature = feature_of(self.config)
        return feature if self.score is None else feature.of(self.score.numbers)

    def require_machine(self, sheet: Mapping[str, Any], name: str) -> None:
        """Check that a data sheet is that of the machine in training, else that of the options.

        Raises
        ------
        ConfigError
            It states another value of a constant that the detector uses.
        """
        for each in self.feature.indicators.values():
            needed, stated = plant_constants(each.options), sheet_constants(each.options)
            # a supply that nothing is computed with is a condition of the windows
            for constant in stated.keys() - ({"supply_pressure"} - needed.keys()):
                own = self.data_sheet.get(constant, getattr(each.options, constant))
                if constant in sheet and is_other(own, sheet[constant]):
                    now, then = (
                        shown_quantity(value, stated[constant]) if isinstance(value, float) else f"{value}"
                        for value in (sheet[constant], own)
                    )
                    raise ConfigError(
                        f"{name}: states {constant} = {now}, but the detector was trained with {then}; train"
                        " one for this machine"
                    )

    @cached_property
    def _rule(self) -> Any:
        """What combines several numbers; None if the output is the score."""
        return self.score and self.config.score and self.score.fitted(self.config.score.kind)

    def scores(self, numbers: Array) -> Array:
        """Scores of windows from their numbers, shape (n_window, n_number)."""
        scores: Array = numbers[:, 0] if self._rule is None else self._rule.score(numbers)
        return scores

    def widening(self, numbers: Array) -> float:
        """How much less certain a score is than at the nearest conditions of the healthy windows."""
        return float(self._rule.widening(numbers[None])[0]) if hasattr(self._rule, "widening") else 1.0

    def cause(self, numbers: Array) -> str:
        """Of two flows with limits of their own, the one that alarms, and what looks like it."""
        if len(names := self.feature.judged) < 2:
            return ""
        spreads = self._rule.spreads(numbers[None])[0]
        # a hole adds as much to the flow of K_i as to the whole flow, a gap little or a part
        flows = spreads * self._rule.spread
        like = LIKE[int(flows[0] < _HOLE * flows[-1])]
        return f"{names[self._rule.standardised.kept[spreads.argmax()]]}, {like}"

    @property
    def n_every(self) -> int:
        """Samples from one window to the next."""
        return self.config.window.n_every(self.n_sample, self.sampling_frequency)

    @property
    def score_name(self) -> str:
        """Name of the score, such as ``dwt.d2`` or ``mahalanobis(P1 x)``."""
        if self.feature.judged:
            return self.feature.label
        assert self.config.score is not None
        return f"{self.config.score.kind}({' '.join(channel.symbol for channel in self.channels)})"

    @property
    def alarm_text(self) -> str:
        """What raises an alarm, such as ``below 29 kPa or above 257 kPa``; with a chart its limit alone."""
        if self.chart is not None and self.config.chart is not None:
            return f"where their chart {self.config.chart.chart} reaches {plain(self.chart.limit, 4)}"
        ends = [("below", self.limits.low), ("above", self.limits.high)]
        if len(self.feature.judged) > 1 and (rule := self._rule) and self.limits.high is not None:
            beyond = (self.limits.high - rule.origin) * rule.spread / rule.spread[0]
            if not rule.low.size:
                beyond += rule.standardised.centre + rule.standardised.scale * rule.coefficients[:, 0]
            ends = [("above", float(each)) for each in beyond]
        return " or ".join(f"{side} {self.score_text(end)}" for side, end in ends if end is not None)

    def score_text(self, score: float) -> str:
        """A score with four digits, in a unit that suits the limits."""
        ends = [abs(end) for end in (self.limits.low, self.limits.high) if end is not None]
        unit = readable_unit(self.unit, max(ends, default=0.0))
        number = plain(convert(score, unit, self.unit), 4)
        return number if unit == "1" else f"{number} {unit}"


def detector_text(file: DetectorFile) -> str:
    """Detector file as readable JSON: SI, lists of numbers on one line."""
    record = file.model_dump(mode="json", by_alias=True)
    text = json.dumps(record, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    return _NUMBERS_PER_LINE.sub(lambda numbers: "[" + " ".join(numbers[1].split()) + "]", text)


def load_detector(path: Path) -> DetectorFile:
    """Read a trained detector."""
    content = _read(path)
    try:
        file = DetectorFile.model_validate_json(content, strict=True)
        mistakes = [*_inconsistencies(file)]
    except ValidationError as errors:
        mistakes = [_mistake(error) for error in errors.errors()]
    if mistakes := [each for each in mistakes if each[0] == "version"] or mistakes:
        raise ConfigError([Issue(_shown(text), _shown(where), str(path)) for where, text in mistakes])
    return file


def is_detector(path: Path) -> bool:
    """Whether a file declares itself a detector file, of any version."""
    try:
        return bool(_read(path))
    except ConfigError:
        return False


def _read(path: Path) -> bytes:
    """The content of a file that declares itself a detector file."""
    if path.exists() and not path.is_file():
        raise ConfigError(f"{path}: is not a regular file")
    try:
        with open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror}") from None
    try:
        data = json.loads(content) if len(content) <= MOST_BYTES else None
    except (RecursionError, ValueError):
        data = None
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        raise ConfigError(f'{path}: is not a detector file; those contain "schema": "{SCHEMA}"')
    return content


def _mistake(error: Any) -> tuple[str, str]:
    path = tuple(part for part in error["loc"] if part != "[key]")
    return dotted(path), describe_error(error, known_keys(DetectorFile, path[:-1]))


def _shown(text: str) -> str:
    """Text from a file, shortened to one line."""
    line = "".join(sign if sign.isprintable() else repr(sign)[1:-1] for sign in text)
    return line if len(line) <= _MOST_SHOWN else f"{line[:_MOST_SHOWN]}…"


def _inconsistencies(file: DetectorFile) -> Iterator[tuple[str, str]]:
    """Key and message of what makes a file unusable, in itself or with this version of hydrofdi."""
    config = file.config
    unsound = [(dotted(("config", *path)), text) for path, text in unmakable(config)]
    yield from unsound
    yield from ((where, text) for where, is_wrong, text in _checks(file) if is_wrong)
    if unsound or (config.score is None) != (file.score is None):
        return
    feature = feature_of(config)
    if file.score and config.score:
        for name in file.score.numbers:
            if name not in feature.numbers:
                yield "score.numbers", f"{name} is not among those of config.score"
                return
        try:
            file.score.fitted(config.score.kind)
        except ValueError as error:
            where, _, text = str(error).partition(": ")
            yield where, text
    for label, indicator in file.feature.indicators.items():
        if indicator.version != (version := file.indicator_versions.get(label)):
            text = f"{label} has version {indicator.version} here, not {version}; train it again"
            yield "indicator_versions", text
    if missing := sorted(file.feature.channels - set(file.channels)):
        yield "channels", f"{file.score_name} needs {missing[0]}, which is missing"


def _checks(file: DetectorFile) -> Iterator[tuple[str, bool, str]]:
    """Key, whether it is wrong, and what is allowed."""
    config, window, centre = file.config, file.config.window, file.healthy.centre
    yield "config.direction", config.direction is None, "is missing"
    yield "config.output", not (config.output or config.score), "is missing"
    yield "score", (config.score is None) != (file.score is None), "requires config.score, and vice versa"
    yield "chart", (config.chart is None) != (file.chart is None), "requires config.chart, and vice versa"
    for key, end, sign, without in (
        ("limits.low", file.limits.low, 1.0, Direction.RISING),
        ("limits.high", file.limits.high, -1.0, Direction.FALLING),
    ):
        is_wrong = (end is None) is not (config.direction is without)
        yield key, is_wrong, f"is required unless the direction is {without}, and allowed only then"
        beyond = end is not None and sign * end > sign * centre
        yield key, beyond, "healthy.centre must lie within the limits"
    n_sample = round((window.duration or 0.0) * file.sampling_frequency)
    yield "n_sample", file.n_sample != n_sample, "does not match config.window.duration"
    if window.by == "cycle":
        yield "drive", file.drive is None, "is missing"
        yield "channels", window.channel not in file.channels, f"must contain {window.channel}"
