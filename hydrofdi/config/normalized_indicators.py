"""The ``indicators`` of an experiment, in the form that its model holds."""

from __future__ import annotations

from typing import Any

from hydrofdi.config.analysis import DWT
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators
from hydrofdi.settings.yaml_source import Source


def normalize_indicators(source: Source) -> None:
    """The ``indicators`` of a source as ``label: {options}``; mistakes are collected.

    Options of the indicator ``dwt`` under its own label are those of the section ``wavelet``.
    """
    given = source.data.get("indicators")
    if given is None:
        source.data.pop("indicators", None)
        return
    if isinstance(given, dict) and isinstance(given.get(DWT), dict):
        given = given | {DWT: _moved_to_wavelet(source, given[DWT])}
    try:
        made = make_indicators(given, source, ("indicators",))
    except ConfigError:
        source.data["indicators"] = {}
        return
    options = given if isinstance(given, dict) else {}
    source.data["indicators"] = {label: options.get(label) or {} for label in made}


def _moved_to_wavelet(source: Source, options: dict[str, Any]) -> dict[str, Any]:
    """What is left of the options of ``dwt`` once the section ``wavelet`` has taken them over."""
    wavelet = source.data.get("wavelet") or {}
    for name, value in options.items():
        if name in ("channel", "kind"):
            message = f"the label {DWT} is the transform of P1; give it another label, with 'kind: {DWT}'"
            source.mistakes.append(source.mistake(("indicators", DWT, name), message))
            continue
        if isinstance(wavelet, dict) and wavelet.get(name, value) != value:
            message = f"wavelet.{name} says {wavelet[name]!r}; give it once"
            source.mistakes.append(source.mistake(("indicators", DWT, name), message))
        source.origins[("wavelet", name)] = source.origin(("indicators", DWT, name))
        wavelet = {**wavelet, name: value} if isinstance(wavelet, dict) else wavelet
    source.data["wavelet"] = wavelet
    return {}
