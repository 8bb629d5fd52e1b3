"""Records that are played as streams, and the streams of many machines that one process monitors."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from os import PathLike
from typing import TYPE_CHECKING, Any, TextIO, Unpack

from hydrofdi.api.sources import Described, Samples, open_records
from hydrofdi.detectors.file import is_detector
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.replaying import replayed
from hydrofdi.monitor.replaying import text_sender as text_sender
from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk
from hydrofdi.settings.arguments import names_of, path_of, positive_of

if TYPE_CHECKING:
    from hydrofdi.monitor.loop import Ending


def replay(
    data: Any,
    *,
    rate: str | float | None = "max",
    record: str = "",
    now: bool = False,
    settings: Sequence[str] = (),
    **samples: Unpack[Samples],
) -> Iterator[Chunk]:
    """Play records as a stream, for trying a detector out.

    Parameters
    ----------
    data : path, Run, Results, array_like, mapping, DataFrame, DataArray, Dataset, or list of these
        Records, as `hydrofdi.measure` takes them. They follow each other with a short gap.
    rate : str or float, optional
        Samples in a second, such as ``"500 Hz"``; ``"max"``, as fast as they are taken; None, as measured.
    record : str, optional
        Replay only one record: its number, from 1, or its name.
    now : bool
        Start time at the present, in seconds since 1970.
    settings : sequence of str, optional
        ``KEY=VALUE`` of an experiment that is simulated.
    sampling_frequency, channel, unit
        Of records in memory, as in `hydrofdi.measure`.

    Yields
    ------
    Chunk
        Up to 4,096 samples, ``time`` [s] and ``channels`` in SI; `Detector.watch` takes them.

    Raises
    ------
    ConfigError, DataError, StoreError
        An argument is invalid, or the records cannot be read.

    Examples
    --------
    >>> import hydrofdi, numpy
    >>> chunks = list(hydrofdi.replay(numpy.zeros(1000), sampling_frequency="1 kHz"))
    >>> sum(chunk.n_time for chunk in chunks)
    1000
    """
    (chosen,) = names_of("record", record, "the number or name of a record") if record != "" else [""]
    stated = names_of("settings", settings, "texts such as 'fluid.bulk_modulus=689 MPa'")
    sources = open_records(data, tuple(Channel), Described(**samples, settings=stated))
    if rate is not None and rate != "max":
        rate = positive_of("rate", rate, "Hz", "a number in Hz, a text such as '500 Hz', or 'max'")
    pace = math.inf if rate == "max" else rate
    start = time.time() if now else None
    return chain.from_iterable(replayed(source, pace, chosen, start) for source in sources)


def monitor_fleet(
    fleet: str | PathLike[str],
    *,
    state: str | PathLike[str] | None = None,
    log: str | PathLike[str] | None = None,
    metrics: str | None = None,
    partition: str | None = None,
    follow: bool = True,
    on_line: Callable[[dict[str, Any]], None] | TextIO | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> Ending:
    """Judge the streams of many machines, as ``hydrofdi monitor FLEET`` does.

    Parameters
    ----------
    fleet : path
        YAML with the machines, their detectors, and the description of their samples.
    state, log, metrics, partition, optional
        Replace the keys of the same name in the file.
    follow : bool
        Whether to wait for more at the end of files.
    on_line : callable or file object, optional
        Called with each line; to a file, they are written as JSON. The key ``machine`` has the name.
    stop : callable, optional
        Returns whether to end; called several times a second.

    Returns
    -------
    Ending
        The reason why it ended, a text of one sentence.

    Raises
    ------
    ConfigError, StoreError
        The file is wrong, or state or log cannot be used. What goes wrong with a machine is an event.
    """
    from hydrofdi.monitor.configuration import Pattern, load_fleet_config
    from hydrofdi.monitor.loop import Monitor
    from hydrofdi.monitor.opening import Sources

    file = path_of(fleet)
    if file.is_file() and is_detector(file):
        raise ConfigError(f"{file}: is a detector; state the source that it judges behind it")
    files = {key: str(path_of(each).absolute()) for key, each in (("state", state), ("log", log)) if each}
    stated = files | {"metrics": metrics, "partition": partition}
    config = load_fleet_config(file, **{key: value for key, value in stated.items() if value})
    patterns = [Pattern.parse(text, file.parent) for text in config.machines]
    sources = Sources(config, file, patterns, is_followed=follow)
    return Monitor(config, sources, on_line).run(stop)
