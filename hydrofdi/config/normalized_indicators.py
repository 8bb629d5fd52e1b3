"""The ``indicators`` of an experiment, in the form of its model."""

from __future__ import annotations

from typing import Any

from hydrofdi.config.analysis import DWT
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.choice import chosen_options
from hydrofdi.indicators.selection import make_chosen
from hydrofdi.settings.yaml_source import Source


def normalize_indicators(source: Source) -> bool:
    """The ``indicators`` of a source as ``label: {options}``; mistakes are collected.

    Options of the indicator ``dwt`` under its own label are those of the section ``wavelet``.

    Returns
    -------
    bool
        Whether they are valid.
    """
    if "indicators" not in source.data:
        return True
    own = Source(source.data, source.origins)
    chosen = chosen_options(source.data["indicators"], own, ("indicators",))
    if isinstance(chosen.get(DWT), dict):
        chosen[DWT] = _moved_to_wavelet(own, chosen[DWT])
    try:
        make_chosen(chosen, own, ("indicators",))
    except ConfigError:
        source.mistakes.extend(own.mistakes)
        del source.data["indicators"]
        return False
    source.data["indicators"] = {label: dict(options or {}) for label, options in chosen.items()}
    return True


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
