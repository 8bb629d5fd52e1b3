"""Trained detectors, and what they promise."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict
from html import escape
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from hydrofdi.api.arguments import Names, names_of, path_of, refusal
from hydrofdi.api.detectors.healthy_records import LeftOut
from hydrofdi.api.detectors.windows import Tally, channels_read, judged_windows, watched, windows_table
from hydrofdi.api.measuring import constants_text
from hydrofdi.api.sources import Said, open_records
from hydrofdi.detectors.trained.conditions import coverage
from hydrofdi.detectors.trained.file import DetectorFile, detector_text, is_detector, load_detector
from hydrofdi.errors import ConfigError, StoreError
from hydrofdi.evaluation.roc import FEWEST_GROUPS
from hydrofdi.indicators.selection import assumption_text
from hydrofdi.report.table import Table
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import count_text, percent, plain, time_text
from hydrofdi.store.files import require_regular, write_whole_text

_HOUR = 3600.0
_MOST_NAMED = 5

_UNEVEN = 0.75
"""Samples per period by which a window may miss whole periods: the period is known to half a sample."""


def sentences(file: DetectorFile, left_out: LeftOut, *, is_unlabelled: bool) -> Iterator[str]:
    """What the detector judges, what it promises, and what that rests on."""
    feature, window = file.feature, file.config.window
    channels = ", ".join(f"{channel.symbol} ({channel})" for channel in file.channels)
    what = {
        "time": f"windows of {window.duration:g} s" if window.duration else "",
        "cycle": f"the first {window.duration or 0.0:g} s of each cycle of {window.channel}",
        "estimate": f"each estimate of {file.config.indicator}",
    }[window.by]
    every = f", one every {window.every:g} s," if window.every and window.every != window.duration else ""
    yield f"It judges {what}{every} at {file.sampling_frequency:g} Hz and needs {channels}."
    if file.score is not None:
        yield f"It combines {counted(len(file.score.numbers), 'number')}: {', '.join(file.score.numbers)}."
    for constants in dict.fromkeys(constants_text(each.options) for each in feature.indicators.values()):
        if constants:
            yield f"It takes the actuator as {constants}."
    if file.assumed:
        assuming = (
            label
            for label, each in feature.indicators.items()
            if not type(each.options).model_fields.keys().isdisjoint(file.assumed)
        )
        yield f"Warning: {assumption_text(', '.join(assuming), file.assumed)}."
    if " at " in (meaning := feature.meaning):
        yield f"The score is the {meaning}; studies state mean flows, which are smaller."
    if file.chart is None:
        yield f"A score {file.alarm_text} is an alarm."
        yield _threshold(file)
    yield from _basis(file, left_out, is_unlabelled=is_unlabelled)
    if file.chart is not None or alarms_per_hour(file):
        yield promise_text(file)


def promise_text(file: DetectorFile) -> str:
    """What the chart is set for, and what it keeps on healthy scores; without one, what is to be expected."""
    chart, config, per_hour = file.chart, file.config.chart, alarms_per_hour(file)
    if chart is None or config is None:
        if per_hour is None:
            return _threshold(file)
        return (
            f"Without a chart expect {count_text(24.0 * per_hour['wanted'])} false alarms a day; a chart for"
            " one a day needs 24 h of healthy windows."
        )
    kept = "no false alarm" if chart.mean_time is None else f"one in {time_text(chart.mean_time)}"
    least, most = chart.interval
    ends = f"{time_text(least)} to {time_text(most)}" if most is not None else f"at least {time_text(least)}"
    rests = "pieces of records" if chart.rests_on == "pieces" else chart.rests_on
    return (
        f"The chart {config.chart} has the limit {plain(chart.limit, 4)} healthy spreads, set for one false"
        f" alarm in {time_text(config.false_alarm_every)}; its {time_text(chart.hours * _HOUR)} of healthy"
        f" scores ({rests} resampled and joined) show {kept} ({ends})."
    )


def _threshold(file: DetectorFile) -> str:
    limits, (low, high) = file.limits, file.limits.interval
    at_most = "at most " if limits.method == "tolerance limit" else ""
    hourly = ""
    if per_hour := alarms_per_hour(file):
        least, most = map(count_text, per_hour["interval"])
        hourly = f": {count_text(per_hour['wanted'])} false alarms an hour ({least} to {most})"
    rests = {
        "windows": "windows taken as independent",
        "fleet": f"{counted(file.basis.n_window, 'own window')} and the fleet {file.basis.fleet}",
    }.get(limits.interval_rests_on, f"leave-one-{limits.interval_rests_on[:-1]}-out")
    warmer = f" The limit allows {file.score_text(limits.allowance)} for oil that is 15 K warmer than in the"
    warmer += " records, which do not state its temperature."
    return (
        f"Designed for a false-alarm rate of {at_most}{percent(limits.false_alarm_rate)} per"
        f" {'window' if file.n_sample else 'estimate'}; {100.0 * limits.confidence:.4g} % confidence interval"
        f" {percent(low)} to {percent(high)} ({rests}){hourly}."
        f"{warmer if limits.allowance else ''}"
    )


def _basis(file: DetectorFile, left: LeftOut, *, is_unlabelled: bool) -> Iterator[str]:
    basis, window = file.basis, file.config.window
    groups = f" in {counted(basis.n_group, 'group')}" if basis.n_group else ""
    what = "windows that do not overlap" if file.n_sample else "estimates"
    records, n_more = counted(basis.n_record, "healthy record"), len(basis.sources) - _MOST_NAMED
    names = ", ".join(basis.sources[:_MOST_NAMED]) + (f" and {n_more:,} more" if n_more > 0 else "")
    yield f"It rests on {basis.n_window:,} {what}, from {records}{groups}: {names}."
    counts = {
        "not judged": ", ".join(f"{count:,} {kind}" for kind, count in basis.not_judged.items()),
        "records that are not healthy training records": left.n_leaking,
        "records without a label": left.n_unlabelled,
    }
    if out := "; ".join(f"{kind} ({count})" for kind, count in counts.items() if count):
        yield f"Left out: {out}."
    yield coverage(file.conditions)
    is_fit = {name for name, output in file.feature.outputs.items() if output.is_fit}
    for name, count in basis.impossible.items():
        if name not in is_fit:
            yield f"Warning: {name} is physically impossible in {count:,} of them."
    if unfit := [name for name in is_fit if 2 * basis.impossible.get(name, 0) > basis.n_window]:
        yield (
            f"Warning: by {' and '.join(sorted(unfit))} of most of them, the data sheet does not fit: the"
            " limits hold for machines like these, but stated sizes of leaks may be wrong."
        )
    if basis.outlying:
        far = [f"{name} ({counted(count, 'window')})" for name, count in basis.outlying.items()]
        more = f" and {len(far) - _MOST_NAMED:,} more" if len(far) > _MOST_NAMED else ""
        yield (
            f"Warning: far beyond the other healthy records: {', '.join(far[:_MOST_NAMED])}{more}."
            " If they are not healthy, a leak is hidden; train without them."
        )
    if basis.drive_period is not None and window.by == "time":
        periods = (window.duration or 0.0) / basis.drive_period
        missed = abs(periods - round(periods)) * basis.drive_period * file.sampling_frequency
        if missed > _UNEVEN * max(1.0, periods):
            yield (
                f"Warning: a window lasts {periods:.5g} periods of the drive ({basis.drive_period:g} s), so"
                " windows contain different parts of it; use a whole number of periods."
            )
    if is_unlabelled:
        yield "No record has a label: all are assumed to be healthy."
    n, one = (basis.n_group, "group") if basis.n_group else (basis.n_record, "record")
    if n < FEWEST_GROUPS:
        yield (
            f"Warning: {counted(n, one)} can say little of false alarms on other days or machines; train on"
            f" {FEWEST_GROUPS} or more."
        )
    if (
        not file.chart
        and file.limits.interval_rests_on == "windows"
        and basis.n_window > max(basis.n_record, basis.n_group)
    ):
        yield "Windows of one record may depend on each other; then the true interval is wider."


def alarms_per_hour(file: DetectorFile) -> dict[str, Any] | None:
    """Alarms of healthy windows per hour of operation; None where windows do not come by time."""
    every, limits = file.config.window.every, file.limits
    if file.config.window.by != "time" or every is None:
        return None
    windows = _HOUR / every
    return {
        "wanted": limits.false_alarm_rate * windows,
        "interval": [share * windows for share in limits.interval],
    }


if TYPE_CHECKING:
    from hydrofdi.monitor.loop import Ending


class Detector:
    """A trained detector, which judges records window by window.

    `hydrofdi.train` makes one; `Detector.load` reads the file of one.

    Attributes
    ----------
    file : DetectorFile
        Indicator, limits and what its promise rests on, in SI.
    left_out : LeftOut
        Records that its training left out.
    is_unlabelled : bool
        Whether all records were taken as healthy because no source says which are.
    path : Path or None
        Its file; None if it is not saved.

    Examples
    --------
    >>> import hydrofdi, numpy
    >>> noise = numpy.random.default_rng(1).standard_normal((201, 1000))
    >>> healthy, leaking = 5e6 + 1e4 * noise[:200], 5e6 + 1.3e4 * noise[200]
    >>> detector = hydrofdi.train(healthy, output="d2", direction="both", sampling_frequency="1 kHz",
    ...                           false_alarm_rate="2 %")
    >>> detector.save("detector.json")
    >>> same = hydrofdi.Detector.load("detector.json")
    >>> same
    dwt.d2: alarm below ... or above ...; false alarms in 2 % of healthy windows (... to ... %)
    >>> same.judge(leaking, sampling_frequency="1 kHz")["alarm"].tolist()
    [True]
    """

    def __init__(
        self,
        file: DetectorFile,
        path: Path | None = None,
        left_out: LeftOut | None = None,
        *,
        is_unlabelled: bool = False,
    ) -> None:
        if not isinstance(file, DetectorFile):
            raise ConfigError(
                f"Detector: hydrofdi.Detector.load({file!r}) reads a detector file; hydrofdi.train(…) trains"
                " a detector"
            )
        self.file, self.path = file, path
        self.left_out, self.is_unlabelled = left_out or LeftOut(), is_unlabelled

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Detector:
        """The detector in a file that ``hydrofdi train`` or `save` wrote.

        Raises
        ------
        ConfigError
            The file is not a detector file, or has another version.
        """
        file = path_of(path)
        return cls(load_detector(file), file)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the detector as JSON for a person to read.

        Raises
        ------
        StoreError
            The file cannot be written, or exists and is not a detector file.
        """
        out = path_of(path)
        require_place(out)
        write_whole_text(out.resolve(), detector_text(self.file))
        self.path = out

    @property
    def name(self) -> str:
        """What is judged, such as ``dwt.d2``."""
        return self.file.score_name

    @property
    def limits(self) -> tuple[float | None, float | None]:
        """Scores below the first or above the second are alarms; None if there is no such limit."""
        return self.file.limits.low, self.file.limits.high

    @property
    def sampling_frequency(self) -> float:
        """Sampling frequency of the records that it judges [Hz]."""
        return self.file.sampling_frequency

    @property
    def channels(self) -> list[str]:
        """Names of the channels that it reads."""
        return [channel.value for channel in channels_read(self.file)]

    @property
    def false_alarm_rate(self) -> float:
        """Requested share of healthy windows that raise an alarm [-]."""
        return self.file.limits.false_alarm_rate

    @property
    def false_alarm_interval(self) -> tuple[float, float]:
        """Confidence interval of the true share [-]."""
        return self.file.limits.interval

    @property
    def summary(self) -> str:
        """What it judges, its false-alarm rate, and the data behind it; one sentence a line."""
        return "\n".join(self._sentences())

    def _sentences(self) -> list[str]:
        return [*sentences(self.file, self.left_out, is_unlabelled=self.is_unlabelled)]

    def to_dict(self) -> dict[str, Any]:
        """The detector, its promise, and what was left out of its training."""
        return {
            "detector": self.file.model_dump(mode="json", by_alias=True),
            "false_alarms_per_hour": alarms_per_hour(self.file),
            "left_out": asdict(self.left_out),
            "is_unlabelled": self.is_unlabelled,
            "summary": self._sentences(),
        }

    def judge(
        self,
        data: Any,
        *,
        sampling_frequency: str | float | None = None,
        channel: Names = None,
        unit: Names = None,
    ) -> Table:
        """Judge every window of records, as ``hydrofdi detect`` does.

        Parameters
        ----------
        data, sampling_frequency, channel, unit
            Records in files or in memory, as in `hydrofdi.measure`.

        Returns
        -------
        Table
            A row for each window, or record without any: ``record_id``, ``source``, ``group``, ``start`` and
            ``end`` [s], ``score``, ``margin`` in healthy spreads, ``beyond_limit`` (also where the window is
            not judged), ``alarm`` (None where it is not), the ``fault`` and ``reason`` why, and the ``doubt``
            beside a verdict. Its `remarks` say how many windows beyond a limit were not judged, and how many
            verdicts are doubtful.

        Raises
        ------
        ConfigError, DataError, StoreError
            An argument is invalid, or the records cannot be read.
        """
        windows = self.windows(data, sampling_frequency=sampling_frequency, channel=channel, unit=unit)
        return windows_table(self.file, [*windows])

    def windows(
        self,
        data: Any,
        *,
        sampling_frequency: str | float | None = None,
        channel: Names = None,
        unit: Names = None,
    ) -> Tally:
        """The windows of records one after another, for more of them than memory holds.

        Parameters
        ----------
        data, sampling_frequency, channel, unit
            As in `judge`.

        Returns
        -------
        Tally
            Iterate over it once; afterwards it has counted them: ``n_judged``, ``n_alarm``, ``rate``.
        """
        said = Said(sampling_frequency, channel, unit)
        sources = open_records(data, channels_read(self.file), said)
        for source in sources:
            self.file.require_machine(source.data_sheet, source.name)
        return Tally(self.file, chain.from_iterable(judged_windows(self.file, source) for source in sources))

    def watch(
        self,
        chunks: Iterable[Any],
        *,
        sampling_frequency: str | float | None = None,
        channel: Names = None,
        unit: Names = None,
    ) -> Iterator[dict[str, Any]]:
        """Judge a stream as its samples come, as ``hydrofdi monitor`` does.

        Parameters
        ----------
        chunks : iterable
            Samples as they come, a few at a time: arrays, mappings, data frames or datasets as
            `hydrofdi.measure` has them, or what `hydrofdi.replay` yields. Those without time follow each
            other at `sampling_frequency`, by default that of the detector.
        sampling_frequency, channel, unit
            Of chunks, as in `hydrofdi.measure`.

        Yields
        ------
        dict
            A line for each window and each event, with the keys of the lines of ``hydrofdi monitor``
            (docs/monitoring.md). The lines do not depend on how the samples are cut into chunks.

        Raises
        ------
        ConfigError, DataError
            A chunk lacks channels, units or times.

        Examples
        --------
        >>> import hydrofdi, numpy
        >>> noise = numpy.random.default_rng(1).standard_normal((200, 1000))
        >>> detector = hydrofdi.train(5e6 + 1e4 * noise, output="d2", sampling_frequency="1 kHz",
        ...                           false_alarm_rate="2 %")
        >>> for line in detector.watch(5e6 + 1e4 * noise[:2].reshape(20, 100)):
        ...     print(line["line"], line["start"], line["alarm"])
        window 0.0 False
        window 1.0 False
        """
        if not isinstance(chunks, Iterable):
            raise refusal("chunks", "chunks of samples, one after another", chunks)
        return watched(self.file, chunks, Said(sampling_frequency, channel, unit))

    def monitor(
        self,
        source: str | PathLike[str],
        *,
        config: str | PathLike[str] | None = None,
        state: str | PathLike[str] | None = None,
        log: str | PathLike[str] | None = None,
        metrics: str | None = None,
        events: Sequence[str] = (),
        follow: bool = True,
        sampling_frequency: str | float | None = None,
        on_line: Callable[[dict[str, Any]], None] | TextIO | None = None,
        stop: Callable[[], bool] = lambda: False,
    ) -> Ending:
        """Judge a stream for as long as it lasts, as ``hydrofdi monitor`` does.

        Parameters
        ----------
        source : str or path
            A file that grows, ``-`` (standard input), ``mqtt://HOST/TOPIC``, ``mqtts://HOST/TOPIC`` or
            ``opc.tcp://HOST:PORT``.
        config : path, optional
            YAML with the channels of the source, and how it is reached.
        state : path, optional
            State file to resume from after a restart; without it, nothing is kept.
        log : path, optional
            Also append every line to this file, once.
        metrics : str, optional
            Address at which metrics are served for Prometheus, ``HOST:PORT``.
        events : sequence of str, optional
            Addresses to which events are sent: ``mqtt(s)://HOST/TOPIC``.
        follow : bool
            Whether to wait for more at the end of a file.
        sampling_frequency : str or float, optional
            Of text without a column of time [Hz].
        on_line : callable or file object, optional
            Called with each line, as `watch` yields them; to a file, they are written as JSON.
        stop : callable, optional
            Returns whether to end; called several times a second.

        Returns
        -------
        Ending
            The reason why it ended, a text of one sentence.

        Raises
        ------
        ConfigError, DataError, StoreError
            An argument is invalid, or the records cannot be read.
        """
        from hydrofdi.monitor.configuration import load_monitor_config
        from hydrofdi.monitor.loop import single_monitor
        from hydrofdi.monitor.machines import Kind
        from hydrofdi.monitor.opening import open_stream

        if self.path is None and "://" in str(source):
            raise ConfigError("save the detector first: the broker identifies it by the path of its file")
        if not isinstance(metrics, str | None):
            raise refusal("metrics", "HOST:PORT", metrics)
        addresses = names_of("events", events, "addresses")
        stated = load_monitor_config(None if config is None else path_of(config))
        kind = Kind(self.file, stated, str(config))
        stream = open_stream(
            source if isinstance(source, str) else str(path_of(source)),
            kind,
            sampling_frequency=Said(sampling_frequency).frequency,
            is_followed=follow,
            is_resumed=state is not None,
        )
        return single_monitor(
            kind,
            stream,
            on_line,
            self.path or Path("detector.json"),
            state=None if state is None else path_of(state),
            log=None if log is None else path_of(log),
            metrics=metrics or "",
            events=addresses,
        ).run(stop)

    def __repr__(self) -> str:
        low, high = (percent(share) for share in self.false_alarm_interval)
        what = "windows" if self.file.n_sample else "estimates"
        rate = f"false alarms in {percent(self.false_alarm_rate)} of healthy {what}"
        rate = promise_text(self.file) if self.file.chart else f"{rate} ({low.removesuffix(' %')} to {high})"
        return f"{self.name}: alarm {self.file.alarm_text}; {rate}"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self.summary)}</pre>"


def require_place(out: Path) -> None:
    """Check that a detector may be written at a path without harm to anything else."""
    if not out.resolve().parent.is_dir():
        raise StoreError(f"{out}: there is no folder {out.resolve().parent}")
    require_regular(out)
    if out.exists() and not is_detector(out):
        raise StoreError(f"{out}: already exists, is not a detector file and was not changed")


def detect(
    detector: Detector | str | PathLike[str],
    data: Any,
    *,
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
) -> Table:
    """Judge records with a trained detector, window by window, as ``hydrofdi detect`` does.

    Parameters
    ----------
    detector : Detector or path
    data, sampling_frequency, channel, unit
        Records in files or in memory, as in `hydrofdi.measure`.

    Returns
    -------
    Table
        A row for each window, as `Detector.judge` gives it; errors are the same.
    """
    judge = detector if isinstance(detector, Detector) else Detector.load(detector)
    return judge.judge(data, sampling_frequency=sampling_frequency, channel=channel, unit=unit)
