"""Detectors trained on healthy records."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from os import PathLike
from typing import Any

from hydrofdi.api.detectors.detector import Detector, require_place
from hydrofdi.api.sources import Described, open_records
from hydrofdi.detectors.trained import configuration
from hydrofdi.detectors.trained.configuration import (
    config_of,
    options_of_machine,
    require_same_score,
    setting_keys,
)
from hydrofdi.detectors.trained.file import Made, fleet_at
from hydrofdi.detectors.trained.training import train as train_on
from hydrofdi.errors import ConfigError
from hydrofdi.execution.simulated import SimulatedRecords
from hydrofdi.indicators.selection import Indicators, of_machine
from hydrofdi.records import Channel, RecordSource
from hydrofdi.settings.arguments import Names, Texts, names_of, path_of
from hydrofdi.settings.files import located, plain
from hydrofdi.store.experiment_data import SIGNAL_OF_CHANNEL, ExperimentData, StoredRecords
from hydrofdi.store.names import stored_signals
from hydrofdi.store.results import read_results
from hydrofdi.studies.detecting import winner_settings
from hydrofdi.studies.healthy import HealthyRecords
from hydrofdi.version import __version__


def train(
    data: Any,
    indicator: Indicators | None = None,
    *,
    healthy: str | int | Sequence[str | int] = (),
    best: bool = False,
    sensors: str | Sequence[str] = (),
    fleet: str | PathLike[str] | None = None,
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
        Train the winner of a stored study: the best score that keeps its false-alarm rate, with the rules and
        on the fit records of the study, which are simulated again unless their signals are stored.
    sensors : str or sequence of str
        Sensors that the winner may need, such as ``P1,P2,x,u``; all by default.
    fleet : path, optional
        Detector of a fleet, each machine of which is a group or a record, by `train`: its settings and its
        score are used. If the own healthy windows are too few for a threshold, the limits are those of normal
        scores of a machine like these, given the own windows (at least one).
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
        config, indicator = config_of(indicator), None
    keys, given = setting_keys(), {"indicator": indicator} | settings
    stored = None
    if best:
        if config is not None or indicator is not None:
            raise ConfigError("best: the study chooses the indicators and the score; give neither")
        folders = data if isinstance(data, list | tuple) else [data]
        place = path_of(folders[0]) if len(folders) == 1 and isinstance(folders[0], str | PathLike) else None
        if place is None or not (place.is_dir() or place.suffix == ".h5"):
            found = ", ".join(str(each) if isinstance(each, PathLike) else repr(each) for each in folders)
            raise ConfigError(f"best: expected the results folder of one study; found {found}")
        stored = read_results(place)
        config = winner_settings(stored, names_of("sensors", sensors, "symbols of sensors"))
    elif sensors:
        raise ConfigError("sensors: is for best, the winner of a study")
    of_fleet = None
    if fleet is not None:
        if best or config is not None or indicator is not None:
            raise ConfigError("fleet: its file has the indicator and the settings; give no others")
        of_fleet = fleet_at(path_of(fleet))
        settings_of = of_fleet.config.model_dump(mode="json")
        config = {key: value for key, value in settings_of.items() if value} | {
            "chart": None, "compensate": False, "accept": of_fleet.config.accept,
        }  # fmt: skip
    stated = configuration.stated_detector(
        config if config is None or isinstance(config, Mapping) else path_of(config),
        {
            keys.get(name, (name,)) if not isinstance(value, Mapping) else (name,): (name, plain(value))
            for name, value in given.items()
            if value is not None
        },
    )
    if of_fleet is not None:
        require_same_score(stated, of_fleet.config)
    if out is not None:
        require_place(path_of(out))
    said = Described(sampling_frequency, channel, unit, label, group)
    labels = tuple(names_of("healthy", healthy, "labels of healthy records"))
    feature = configuration.feature_of(stated)
    needed = feature.channels | feature.optional_channels | {stated.window.channel}
    needed |= set() if best else {Channel.OIL_TEMPERATURE}  # a winner is trained as the study judged it
    sources = open_records(data, needed, said) if stored is None else [_records_of(stored, needed)]
    if of_fleet is not None:
        for source in sources:
            of_fleet.require_machine(source.data_sheet, source.name)
    machine = of_machine(feature.indicators, sources)
    records, stated = HealthyRecords(sources, labels), options_of_machine(stated, machine)
    made = Made(hydrofdi=__version__, time=datetime.now(UTC).isoformat(timespec="seconds"), command=command)
    faulty = replace(records, is_faulty=True)
    names, fleet_name = [source.name for source in sources], "" if fleet is None else path_of(fleet).name
    is_measured = not any(isinstance(each, SimulatedRecords | StoredRecords) for each in sources)
    file = train_on(records, stated, names, made, faulty, of_fleet, fleet_name, is_measured)
    records.left_out.n_leaking -= faulty.n_taken if file.score and file.score.n_faulty else 0
    detector = Detector(file, left_out=records.left_out, is_unlabelled=records.is_unlabelled)
    if out is not None:
        detector.save(out)
    return detector


def _records_of(stored: ExperimentData, needed: Collection[Channel]) -> RecordSource:
    """The records of a study: its stored signals where they suffice, else simulated again."""
    store, name = stored.experiment.store, str(stored.path)
    signals = {signal for channel, signal in SIGNAL_OF_CHANNEL.items() if channel in needed}
    signals -= stored.experiment.absent_signals
    if signals <= stored_signals(store.signals) and store.dtype == "float64":
        return StoredRecords(stored, name, needed)
    return SimulatedRecords(stored.experiment, name, needed)
