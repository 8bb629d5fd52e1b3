"""Many machines that one process monitors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any, TextIO

from hydrofdi.api.arguments import names_of, path_of
from hydrofdi.detectors.trained.file import is_detector
from hydrofdi.errors import ConfigError

if TYPE_CHECKING:
    from hydrofdi.monitor.loop import Ending


def monitor_fleet(
    fleet: str | PathLike[str],
    *,
    state: str | PathLike[str] | None = None,
    log: str | PathLike[str] | None = None,
    metrics: str | None = None,
    events: Sequence[str] = (),
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
    state, log, metrics, events, partition, optional
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
    from hydrofdi.monitor.fleet_configuration import Pattern, load_fleet_config
    from hydrofdi.monitor.loop import Monitor
    from hydrofdi.monitor.opening import Sources

    file = path_of(fleet)
    if file.is_file() and is_detector(file):
        raise ConfigError(f"{file}: is a detector; state the source that it judges behind it")
    files = {key: str(path_of(each).absolute()) for key, each in (("state", state), ("log", log)) if each}
    stated = files | {
        "metrics": metrics,
        "events": names_of("events", events, "addresses"),
        "partition": partition,
    }
    config = load_fleet_config(file, **{key: value for key, value in stated.items() if value})
    patterns = [Pattern.parse(text, file.parent) for text in config.machines]
    sources = Sources(config, file, patterns, is_followed=follow)
    return Monitor(config, sources, on_line).run(stop)
