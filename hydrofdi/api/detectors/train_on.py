"""Sources of records → the file of a trained detector."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from hydrofdi import __version__
from hydrofdi.api.assumed_plant import assumed_constants
from hydrofdi.api.detectors.healthy_records import HealthyRecords, LeftOut
from hydrofdi.detectors.trained import DetectorConfig, DetectorFile
from hydrofdi.detectors.trained.file import Made
from hydrofdi.detectors.trained.measuring import feature_of
from hydrofdi.detectors.trained.reading import detector_text, is_detector
from hydrofdi.detectors.trained.training import train
from hydrofdi.errors import StoreError
from hydrofdi.records import Channel, RecordSource
from hydrofdi.store.files import require_regular, write_whole_text


@dataclass(frozen=True)
class Training:
    """A trained detector and what was left out.

    Attributes
    ----------
    file : DetectorFile
    left_out : LeftOut
    is_unlabelled : bool
        Whether all records were taken as healthy because no source says which are.
    """

    file: DetectorFile
    left_out: LeftOut
    is_unlabelled: bool


def train_on(
    sources: Sequence[RecordSource],
    config: DetectorConfig,
    *,
    healthy: Sequence[str] = (),
    command: str = "",
) -> Training:
    """Train a detector on the healthy records of some sources.

    Parameters
    ----------
    sources : sequence of RecordSource
        With the channels of `channels_needed`.
    config : DetectorConfig
    healthy : sequence of str
        Labels of healthy records beside those that descriptions name.
    command : str
        What the file says of how it was made.

    Raises
    ------
    ConfigError, DataError, StoreError
        A source cannot be read, or does not say which records are healthy.
    NotStatedError
        There are too few healthy records.
    """
    records = HealthyRecords(sources, healthy)
    made = Made(hydrofdi=__version__, time=datetime.now(UTC).isoformat(timespec="seconds"), command=command)
    file = train(records, config, [source.name for source in sources], made)
    assumed = assumed_constants(sources, feature_of(config).indicator.options)
    file = file.model_copy(update={"assumed": assumed})
    return Training(file, records.left_out, records.is_unlabelled)


def channels_needed(config: DetectorConfig) -> frozenset[Channel]:
    """Channels that training looks at."""
    indicator = feature_of(config).indicator
    return indicator.channels | indicator.optional_channels | {config.window.channel}


def require_place(out: Path) -> None:
    """Check that a detector may be written at a path without harm to anything else.

    Raises
    ------
    StoreError
        Something else stands there, or there is no such folder.
    """
    if not out.resolve().parent.is_dir():
        raise StoreError(f"{out}: there is no folder {out.resolve().parent}")
    require_regular(out)
    if out.exists() and not is_detector(out):
        raise StoreError(f"{out}: already exists, is not a detector file and was not changed")


def write_detector(out: Path, file: DetectorFile) -> None:
    """Write the file of a detector, whole or not at all; a symbolic link stays one.

    Raises
    ------
    StoreError
        It cannot be written, or something else stands there.
    """
    require_place(out)
    write_whole_text(out.resolve(), detector_text(file))
