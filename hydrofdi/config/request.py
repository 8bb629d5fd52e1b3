"""All that determines a row of a sweep, its record and its analysis, and access to it by dotted names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Annotated, Any, ClassVar

from pydantic import TypeAdapter
from pydantic.fields import FieldInfo

from hydrofdi.config.parameters import RECORD_SECTIONS, SENSING, RunParameters
from hydrofdi.config.sections.analysis import AnalysisConfig
from hydrofdi.config.sections.fit import require_discard_fits, require_record_fits
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.transforms.configuration import WaveletConfig


class RunRequest(RunParameters):
    """The validated sections of one row, in SI: those of its record, and those of its analysis."""

    analysis: AnalysisConfig = AnalysisConfig()
    """What is analysed of a record."""
    wavelet: WaveletConfig = WaveletConfig()
    """Wavelet transform."""

    fitting_sections: ClassVar[tuple[tuple[str, ...], ...]] = (
        *RunParameters.fitting_sections,
        ("input", "record", "analysis", "wavelet"),
    )

    def require_fit(self, sections: tuple[str, ...]) -> None:
        """Check that the sections of one of `fitting_sections` fit each other.

        Raises
        ------
        ValueError
            They do not fit.
        """
        if "wavelet" not in sections:
            super().require_fit(sections)
            return
        require_discard_fits(self.analysis, self.input, self.record)
        require_record_fits(self.record, self.analysis, self.input.period, self.wavelet)

    @property
    def parameters(self) -> RunParameters:
        """Those of the record alone."""
        return RunParameters().with_valid_sections({name: self.__dict__[name] for name in RECORD_SECTIONS})

    @property
    def n_discarded(self) -> int:
        """Number of samples that the analysis leaves out."""
        return round(self.analysis.discarded_time(self.input.period) * self.record.sampling_frequency)

    @property
    def n_kept(self) -> int:
        """Number of samples that are analysed."""
        return self.record.n_sample - self.n_discarded

    def with_ideal_sensors(self) -> RunRequest:
        """The same with every signal shown as it is."""
        return self._with_defaults(SENSING)

    def plainly_observed(self) -> RunRequest:
        """The same plant and drive, with every signal shown as it is and the default analysis."""
        return self._with_defaults(OBSERVATION)

    def _with_defaults(self, sections: Mapping[str, type[Section]]) -> RunRequest:
        plain = {name: kind() for name, kind in sections.items() if not self.__dict__[name].is_default}
        return self.with_valid_sections(plain) if plain else self


ANALYSIS_SECTIONS = tuple(sorted(RunRequest.model_fields.keys() - RunParameters.model_fields.keys()))
"""The sections that say how a record is analysed."""

OBSERVATION: dict[str, type[Section]] = SENSING | {"analysis": AnalysisConfig, "wavelet": WaveletConfig}
"""Sections that say how signals are measured and analysed, not what happens."""


def parameter_names(kind: type[RunParameters] = RunRequest) -> Iterator[str]:
    """The dotted names of all parameters of a run, or of a record alone."""
    for section, info in kind.model_fields.items():
        assert isinstance(info.annotation, type)
        for field in info.annotation.model_fields:
            yield f"{section}.{field}"


def validate_parameter(name: str, value: Any) -> Any:
    """A value for a dotted name, in SI, checked on its own.

    Raises
    ------
    pydantic.ValidationError
        The value is not one that the parameter can take.
    """
    return _adapter(name).validate_python(value)


def parameter_unit(name: str) -> str | None:
    """SI unit of a dotted name; None if it is not a quantity."""
    quantity = parameter_quantity(name)
    return None if quantity is None else quantity.unit


def parameter_quantity(name: str) -> SI | None:
    """Unit and limits of a dotted name; None if it is not a quantity."""
    return field_quantity(_field(name))


def field_quantity(field: FieldInfo) -> SI | None:
    """Unit and limits of a field of a section; None if it is not a quantity."""
    return next((part for part in _flattened_metadata(field) if isinstance(part, SI)), None)


def _flattened_metadata(field: FieldInfo) -> list[Any]:
    nested = [getattr(part, "__metadata__", ()) for part in getattr(field.annotation, "__args__", ())]
    return [*field.metadata, *(item for metadata in nested for item in metadata)]


def _field(name: str) -> FieldInfo:
    section, field = name.split(".")
    annotation: Any = RunRequest.model_fields[section].annotation
    info: FieldInfo = annotation.model_fields[field]
    return info


@lru_cache(maxsize=128)
def _adapter(name: str) -> TypeAdapter[Any]:
    field = _field(name)
    annotation: Any = field.annotation
    return TypeAdapter(Annotated[annotation, *field.metadata] if field.metadata else annotation)
