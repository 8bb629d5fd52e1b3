"""Trained detectors, and what they promise."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict
from html import escape
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from hydrofdi.api.sources import Described, open_records
from hydrofdi.detectors.trained.detector import Detector as TrainedDetector
from hydrofdi.detectors.trained.detector import Tally, judged_windows
from hydrofdi.detectors.trained.file import DetectorFile, detector_text, is_detector, load_detector
from hydrofdi.detectors.trained.promise import alarms_per_hour, promise_text, sentences
from hydrofdi.detectors.trained.windows import watched, windows_table
from hydrofdi.errors import ConfigError, StoreError
from hydrofdi.settings.arguments import Names, names_of, path_of, refusal
from hydrofdi.settings.messages import percent
from hydrofdi.store.files import require_regular, write_whole_text
from hydrofdi.studies.healthy import LeftOut, analysed_batches
from hydrofdi.tables.table import Table

if TYPE_CHECKING:
    from hydrofdi.monitor.loop import Ending


class Detector(TrainedDetector):
    """A trained detector, which judges records and streams window by window.

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
        super().__init__(file)
        self.path = path
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
        said = Described(sampling_frequency, channel, unit)
        sources = open_records(data, self.file.channels, said)
        for source in sources:
            self.file.require_machine(source.data_sheet, source.name)
        batches = (batch for source in sources for batch in analysed_batches(source, labels=True))
        return Tally(self.file, chain.from_iterable(judged_windows(self, batch) for batch in batches))

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
        return watched(self, chunks, Described(sampling_frequency).frequency, channel, unit)

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
            events=addresses,
        ).run(stop)

    def __repr__(self) -> str:
        low, high = (percent(share) for share in self.file.limits.interval)
        rate = f"false alarms in {percent(self.file.limits.false_alarm_rate)} of healthy windows"
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
