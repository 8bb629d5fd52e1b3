"""Trained detectors, and what they promise."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from html import escape
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TextIO, Unpack

import numpy as np

from hydrofdi.api.sources import Described, Samples, open_records
from hydrofdi.detectors import configuration
from hydrofdi.detectors.detector import Detector as TrainedDetector
from hydrofdi.detectors.file import DetectorFile, detector_text, is_detector, load_detector
from hydrofdi.detectors.lines import Line, line_record
from hydrofdi.detectors.promise import alarms_per_hour, promise_text, sentences
from hydrofdi.detectors.windows import Tally, judged_windows
from hydrofdi.errors import ConfigError, DataError, StoreError
from hydrofdi.indicators.measuring import used_channels
from hydrofdi.indicators.selection import Indicators, of_machine
from hydrofdi.records import Channel
from hydrofdi.records.columns import RejectionError
from hydrofdi.records.memory import held, records_of
from hydrofdi.records.recording import samples_of
from hydrofdi.records.streams import Chunk
from hydrofdi.settings.arguments import Names, Texts, names_of, path_of, refusal
from hydrofdi.settings.files import located, plain
from hydrofdi.settings.messages import counted, percent
from hydrofdi.store.files import require_regular, write_whole_text
from hydrofdi.studies.healthy import HealthyRecords, LeftOut, analysed_batches, experiment_of
from hydrofdi.tables.table import Table

if TYPE_CHECKING:
    from hydrofdi.monitor.loop import Ending
    from hydrofdi.store.experiment_data import ExperimentData


class Detector(TrainedDetector):
    """A trained detector, which judges records and streams window by window.

    `fit` makes one of healthy records, which `hydrofdi.train` opens; `load` reads the file of one. `score`
    judges windows; `start` and `step` lead through the samples of a stream.

    Attributes
    ----------
    file : DetectorFile
        Indicator, limits and what its promise rests on, in SI.
    path : Path or None
        Its file; None if it is not saved.
    left_out : LeftOut
        Records that its training left out.
    is_unlabelled : bool
        Whether all records were taken as healthy because no source says which are.

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

    def __init__(self, file: DetectorFile, path: Path | None = None) -> None:
        if not isinstance(file, DetectorFile):
            raise ConfigError(
                f"Detector: hydrofdi.Detector.load({file!r}) reads a detector file; hydrofdi.train(…) trains"
                " a detector"
            )
        super().__init__(file, path)
        self.left_out, self.is_unlabelled = LeftOut(), False

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Self:
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
    def summary(self) -> str:
        """What it judges, its false-alarm rate, and the data behind it; one sentence a line."""
        return "\n".join(self._sentences())

    def _sentences(self) -> list[str]:
        left = self.left_out
        return [*sentences(self.file, left.n_leaking, left.n_unlabelled, is_unlabelled=self.is_unlabelled)]

    def to_dict(self) -> dict[str, Any]:
        """The detector, its promise, and what was left out of its training."""
        return {
            "detector": self.file.model_dump(mode="json", by_alias=True),
            "false_alarms_per_hour": alarms_per_hour(self.file),
            "left_out": asdict(self.left_out),
            "is_unlabelled": self.is_unlabelled,
            "summary": self._sentences(),
        }

    def judge(self, data: Any, **samples: Unpack[Samples]) -> Table:
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
        windows = self.windows(data, **samples)
        return windows.table([*windows])

    def windows(self, data: Any, **samples: Unpack[Samples]) -> Tally:
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
        sources = open_records(data, self.file.channels, Described(**samples))
        for source in sources:
            self.file.require_machine(source.data_sheet, source.name)
        batches = (batch for source in sources for batch in analysed_batches(source, labels=True))
        return Tally(self.file, chain.from_iterable(judged_windows(self, batch) for batch in batches))

    def watch(self, chunks: Iterable[Any], **samples: Unpack[Samples]) -> Iterator[dict[str, Any]]:
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
        said = Described(**samples)
        frequency = said.frequency or self.file.sampling_frequency

        def lines() -> Iterator[Line]:
            state = self.start()
            for chunk in _chunks(chunks, frequency, said.channel, said.unit):
                state, some = self.step(state, chunk)
                yield from some
            yield from self.end(state)[1]

        return (line_record(line, self.file.unit) for line in lines())

    def monitor(
        self,
        source: str | PathLike[str],
        *,
        config: str | PathLike[str] | None = None,
        state: str | PathLike[str] | None = None,
        log: str | PathLike[str] | None = None,
        metrics: str | None = None,
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
        from hydrofdi.monitor.machines import MachineKind
        from hydrofdi.monitor.opening import open_stream

        if self.path is None and "://" in str(source):
            raise ConfigError("save the detector first: the broker identifies it by the path of its file")
        if not isinstance(metrics, str | None):
            raise refusal("metrics", "HOST:PORT", metrics)
        stated = load_monitor_config(None if config is None else path_of(config))
        kind = MachineKind(self.file, stated, str(config))
        stream = open_stream(
            source if isinstance(source, str) else str(path_of(source)),
            kind,
            sampling_frequency=Described(sampling_frequency).frequency,
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
        ).run(stop)

    def __repr__(self) -> str:
        low, high = (percent(share) for share in self.file.limits.interval)
        rate = f"false alarms in {percent(self.file.limits.false_alarm_rate)} of healthy windows"
        rate = promise_text(self.file) if self.file.chart else f"{rate} ({low.removesuffix(' %')} to {high})"
        return f"{self.name}: alarm {self.file.alarm_text}; {rate}"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self.summary)}</pre>"


def _chunks(chunks: Iterable[Any], frequency: float, channel: Names, unit: Names) -> Iterator[Chunk]:
    """Chunks with their instants; those without any follow each other."""
    n_before = 0
    for each in chunks:
        if isinstance(each, Chunk):
            yield each
            continue
        samples = held(each)
        source = records_of(samples, frequency if samples.time is None else None, channel, unit)
        if (n_record := len(source.table.record_ids)) > 1:
            raise DataError(f"{source.name}: has {counted(n_record, 'record')}; a chunk of a stream has one")
        try:
            _, channels, times, since = samples_of(source.table, source.config)
        except RejectionError as rejection:
            raise DataError(f"{source.name}: {rejection.remark.message}") from None
        n_time = next(iter(channels.values())).size
        if times is None:
            times = (n_before + np.arange(n_time)) / frequency
        elif not math.isnan(since):
            times = times + since
        yield Chunk(times, channels)
        n_before += n_time


def require_place(out: Path) -> None:
    """Check that a detector may be written at a path without harm to anything else."""
    if not out.resolve().parent.is_dir():
        raise StoreError(f"{out}: there is no folder {out.resolve().parent}")
    require_regular(out)
    if out.exists() and not is_detector(out):
        raise StoreError(f"{out}: already exists, is not a detector file and was not changed")


def detect(detector: Detector | str | PathLike[str], data: Any, **samples: Unpack[Samples]) -> Table:
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
    return judge.judge(data, **samples)


def train(
    data: Any,
    indicator: Indicators | None = None,
    *,
    healthy: str | int | Sequence[str | int] = (),
    best: bool = False,
    sensors: str | Sequence[str] = (),
    config: str | PathLike[str] | Mapping[str, Any] | None = None,
    out: str | PathLike[str] | None = None,
    command: str = "",
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
    label: Texts = None,
    group: Texts = None,
    **settings: Any,
) -> Detector:
    """Train a detector on healthy records, as ``hydrofdi train`` does.

    Of labelled records those with a healthy label are used, of a sweep the runs without a leak, of a study
    its healthy fit records; of other records all. Too few are refused with the number that is needed.

    Parameters
    ----------
    data : path, Run, Results, array_like, mapping, DataFrame, DataArray, Dataset, or list of these
        Records, as `hydrofdi.measure` takes them.
    indicator : str, path, mapping or sequence of str, optional
        What is measured, ``"dwt"`` by default; a label, where `config` has several. Also in the forms that
        `hydrofdi.measure` takes, ``{"flow_balance": {"spool": "command"}}``; a YAML file or a mapping with
        other keys of a detector stands for `config`.
    healthy : str, int, or sequence of them, optional
        Labels of healthy records, besides those that descriptions name.
    best : bool
        Train the winner of a study, whose results folder is the data: the best score that keeps its
        false-alarm rate, with the rules and on the fit records of the study, which are simulated again unless
        their signals are stored.
    sensors : str or sequence of str
        Sensors that the winner may need, such as ``P1,P2,x,u``; all by default.
    config : path or mapping, optional
        YAML file, or a mapping, with these settings, options of the indicator and a chart; what is given
        beside it wins.
    out : path, optional
        Where the detector is written; `Detector.save` does it later.
    command : str, optional
        The command that the file states as its origin.
    sampling_frequency, channel, unit, label, group
        Of records in memory, as in `hydrofdi.measure`.
    **settings
        Keys of a detector: ``options`` of the indicator, ``output``, ``direction``, ``false_alarm_rate``,
        ``confidence``, ``threshold``, ``accept``, ``score``, ``chart`` and its ``false_alarm_every``; and of
        its windows: ``window``, their duration, ``every``, ``by``, ``edge``. `DetectorConfig` and
        ``hydrofdi train --help`` explain them.

    Returns
    -------
    Detector
        Its `summary` states the false-alarm rate and the data behind it.

    Raises
    ------
    ConfigError
        With every mistake, or too few healthy records.
    DataError, StoreError
        Records cannot be read, or the file cannot be written.

    Examples
    --------
    >>> import hydrofdi, numpy
    >>> pressure = 5e6 + 1e4 * numpy.random.default_rng(1).standard_normal((200, 1000))
    >>> detector = hydrofdi.train(pressure, output="d2", sampling_frequency="1 kHz", false_alarm_rate="2 %")
    >>> detector.file.limits.false_alarm_rate, detector.file.sampling_frequency
    (0.02, 1000.0)
    >>> print(detector.summary)
    It judges windows of 1 s at 1000 Hz and needs P1 (chamber_1_pressure).
    A score ...
    >>> hydrofdi.train(pressure[:10], output="d2", sampling_frequency="1 kHz")
    Traceback (most recent call last):
    hydrofdi.errors.NotStatedError: ... needs 99 healthy windows ...
    """
    is_name = isinstance(indicator, str) and not located(path_of(indicator)).is_file()
    if indicator is not None and config is None and not is_name:
        config, indicator = configuration.config_of(indicator), None
    keys, given = configuration.setting_keys(), {"indicator": indicator} | settings
    stored = None
    if best:
        if config is not None or indicator is not None:
            raise ConfigError("best: the study chooses the indicators and the score; give neither")
        from hydrofdi.studies.detecting import winner_settings

        stored = _study_at(data)
        config = winner_settings(stored, names_of("sensors", sensors, "symbols of sensors"))
    elif sensors:
        raise ConfigError("sensors: is for best, the winner of a study")
    stated = configuration.stated_detector(
        config if config is None or isinstance(config, Mapping) else path_of(config),
        {
            keys.get(name, (name,)) if not isinstance(value, Mapping) else (name,): (name, plain(value))
            for name, value in given.items()
            if value is not None
        },
    )
    if out is not None:
        require_place(path_of(out))
    feature = configuration.feature_of(stated)
    needed = used_channels(feature.indicators) | {stated.window.channel}
    needed |= set() if best else {Channel.OIL_TEMPERATURE}  # a winner is trained as the study judged it
    if stored is None:
        sources = open_records(data, needed, Described(sampling_frequency, channel, unit, label, group))
    else:
        from hydrofdi.execution.simulated import records_of_study

        sources = [records_of_study(stored, needed)]
    records = HealthyRecords(sources, tuple(names_of("healthy", healthy, "labels of healthy records")))
    faulty = replace(records, is_faulty=True)
    detector = Detector.fit(
        records,
        configuration.options_of_machine(stated, of_machine(feature.indicators, sources)),
        sources=[source.name for source in sources],
        faulty=faulty,
        is_measured=all(experiment_of(each) is None for each in sources),
        command=command,
    )
    detector.left_out, detector.is_unlabelled = records.left_out, records.is_unlabelled
    if detector.file.score and detector.file.score.n_faulty:
        detector.left_out.n_leaking -= faulty.n_taken
    if out is not None:
        detector.save(out)
    return detector


def _study_at(data: Any) -> ExperimentData:
    from hydrofdi.store.results import read_results

    folders = data if isinstance(data, list | tuple) else [data]
    if len(folders) != 1 or not isinstance(folders[0], str | PathLike):
        raise ConfigError("best: expected the results folder of one study")
    return read_results(path_of(folders[0]))
