"""What is measured of a record: the analysed part, and the indicators."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from hydrofdi.errors import ConfigError
from hydrofdi.indicators import Indicator
from hydrofdi.indicators.absent import AbsentIndicator
from hydrofdi.indicators.registry import sound_indicator
from hydrofdi.transforms.configuration import WaveletConfig

Indicators = Mapping[str, Indicator[Any]]
"""Label → indicator."""

DWT = "dwt"
"""Label of the indicator of the paper. Its options are the section ``wavelet``."""


@dataclass(frozen=True)
class IndicatorChoice:
    """The indicators of an experiment: label → options, as canonical JSON.

    The indicator `DWT` has the wavelet of a row, which may vary from row to row.
    """

    text: str = json.dumps({DWT: {}})

    @classmethod
    def of(cls, options: Mapping[str, Mapping[str, Any]]) -> IndicatorChoice:
        """The choice of labels with valid options."""
        return cls(json.dumps(options))

    def made(self, wavelet: WaveletConfig) -> Indicators:
        """Label → indicator, for the wavelet of a row."""
        return _made(self.text, wavelet)

    @property
    def absent(self) -> dict[str, str]:
        """Labels of indicators that are not installed, and why; they are only found in stored experiments."""
        made = _made(self.text, PAPER).items()
        return {label: each.reason for label, each in made if isinstance(each, AbsentIndicator)}

    @property
    def identity(self) -> str:
        """Name, version and options of each indicator; empty if they are the default.

        Raises
        ------
        ConfigError
            An indicator is not installed, so its version is unknown.
        """
        return _identity(self.text)


@lru_cache(maxsize=1024)
def _made(text: str, wavelet: WaveletConfig) -> Indicators:
    options = json.loads(text)
    if DWT in options:
        options[DWT] = wavelet.stated()
    return {label: _installed(label, given) for label, given in options.items()}


def _installed(label: str, options: Mapping[str, Any]) -> Indicator[Any]:
    """An indicator, or a placeholder for one that is not installed."""
    own = dict(options)
    try:
        return sound_indicator(str(own.pop("kind", label)), own)
    except ConfigError as error:
        return AbsentIndicator(str(error))


@lru_cache(maxsize=1024)
def _identity(text: str) -> str:
    made = _made(text, WaveletConfig())
    for each in made.values():
        if isinstance(each, AbsentIndicator):
            raise ConfigError(f"{each.reason}; install the package that adds it")
    shown = {label: [made[label].name, made[label].version, made[label].options.stated()] for label in made}
    return "" if shown == {DWT: [DWT, 1, {}]} else json.dumps(shown, separators=(",", ":"))


PAPER = WaveletConfig()
"""The transform of the paper."""

DEFAULT_CHOICE = IndicatorChoice()


@dataclass(frozen=True)
class Analysis:
    """What is measured of one record.

    Attributes
    ----------
    n_discarded : int
        Samples at its start that are left out.
    wavelet : WaveletConfig
    choice : IndicatorChoice
    """

    n_discarded: int = 0
    wavelet: WaveletConfig = PAPER
    choice: IndicatorChoice = DEFAULT_CHOICE

    @property
    def indicators(self) -> Indicators:
        """Label → indicator."""
        return self.choice.made(self.wavelet)

    def identities(self, record_id: str) -> dict[str, str]:
        """Label → identity of what its indicator measures of a record.

        It is the hash of the record's identity, the indicator, its version and its options, to which the
        samples belong that are left out.
        """
        return {label: self._identity(record_id, each) for label, each in self.indicators.items()}

    def _identity(self, record_id: str, indicator: Indicator[Any]) -> str:
        parts = (
            record_id,
            indicator.name,
            indicator.version,
            self.n_discarded,
            indicator.options.stated_text,
        )
        return hashlib.sha256("\n".join(map(str, parts)).encode()).hexdigest()[:16]


DEFAULT_ANALYSIS = Analysis()
