"""Records as streams."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any

from hydrofdi.api.arguments import names_of, positive_of
from hydrofdi.api.monitoring.replayed import Pace, replayed
from hydrofdi.api.records.held import Names
from hydrofdi.api.records.sources import Said, sources_of
from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk


def replay(
    data: Any,
    *,
    rate: str | float | None = "max",
    record: str = "",
    now: bool = False,
    settings: Sequence[str] = (),
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
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
        Whether time starts at the present one, in seconds since 1970.
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
    pace = Pace(_rate(rate))
    (chosen,) = names_of("record", record, "the number or name of a record") if record != "" else [""]
    stated = names_of("settings", settings, "texts such as 'fluid.bulk_modulus=689 MPa'")
    sources = sources_of(data, tuple(Channel), Said(sampling_frequency, channel, unit, settings=stated))
    start = time.time() if now else None
    return chain.from_iterable(replayed(source, pace, chosen, start) for source in sources)


def _rate(given: str | float | None) -> float | None:
    """Samples in a second; None for the rate of the record."""
    if given is None or given == "max":
        return None if given is None else math.inf
    return positive_of("rate", given, "Hz", "a number in Hz, a text such as '500 Hz', or 'max'")
