"""Description of an indicator, for the command line and the documentation."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from pydantic.fields import FieldInfo

from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.registry import indicator_kind, sound_indicator
from hydrofdi.records import Channel
from hydrofdi.settings.quantities import field_quantity, field_texts
from hydrofdi.settings.readable import shown_quantity


@dataclass(frozen=True)
class Option:
    """An option of an indicator.

    Attributes
    ----------
    name : str
    default : str
        With a unit that suits it, as a configuration may state it; ``–`` if there is none.
    unit : str
        SI; ``1`` for dimensionless numbers, empty if the option is not a quantity.
    text : str
        Description.
    """

    name: str
    default: str
    unit: str
    text: str


@dataclass(frozen=True)
class Description:
    """An indicator with its default outputs and channels."""

    name: str
    version: int
    summary: str
    source: str
    equation: str
    caution: str
    is_cheap: bool
    needs_scale: bool
    channels: tuple[Channel, ...]
    optional_channels: tuple[Channel, ...]
    outputs: tuple[Output, ...]
    options: tuple[Option, ...]

    @property
    def cost(self) -> str:
        """Cost class, for tables."""
        return "cheap" if self.is_cheap else "costly"


def describe(name: str) -> Description:
    """Describe an indicator.

    Raises
    ------
    ConfigError
        There is no indicator of this name, or it cannot be loaded.
    """
    kind = indicator_kind(name)
    indicator, texts = sound_indicator(name), field_texts(kind.Options)
    options = []
    for field, info in kind.Options.model_fields.items():
        unit, default = _unit(info), info.get_default(call_default_factory=True)
        options.append(Option(field, _shown(default, unit), unit, " ".join(texts.get(field, "").split())))
    return Description(
        name, kind.version, kind.summary, kind.source, kind.equation, kind.caution, kind.is_cheap,
        kind.needs_scale,
        tuple(sorted(indicator.channels)), tuple(sorted(indicator.optional_channels)),
        tuple(indicator.outputs), tuple(options),
    )  # fmt: skip


def _shown(value: Any, unit: str) -> str:
    if value is None or value in ((), [], {}):
        return "–"
    if isinstance(value, tuple | list):
        return ", ".join(_shown(item, unit) for item in value)
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, float):
        return shown_quantity(value, unit or "1")
    return str(value)


def _unit(info: FieldInfo) -> str:
    quantity = field_quantity(info)
    return quantity.unit if quantity else ""
