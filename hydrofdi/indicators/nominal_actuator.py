"""Prior knowledge of an actuator from data sheets: areas, volumes and its valve."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import model_validator

from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI, Section, field_quantity


@dataclass(frozen=True)
class PlantConstant:
    """Annotation of an option that describes the plant.

    Attributes
    ----------
    option : str
        The constant is used only if this option has one of the `values`; always if empty.
    """

    option: str = ""
    values: tuple[Any, ...] = ()

    def is_used(self, options: Section) -> bool:
        """Whether the indicator uses the constant with these options."""
        return not self.option or getattr(options, self.option, None) in self.values


def plant_constants(options: Section) -> dict[str, str]:
    """Plant constant used with these options → its SI unit."""
    found = {}
    for name, info in type(options).model_fields.items():
        marks = [each for each in info.metadata if isinstance(each, PlantConstant)]
        if any(mark.is_used(options) for mark in marks):
            quantity = field_quantity(info)
            found[name] = quantity.unit if quantity else "1"
    return found


def constants_not_given(options: Section) -> tuple[str, ...]:
    """Plant constants that are used but were left at their defaults."""
    return tuple(name for name in plant_constants(options) if name not in options.model_fields_set)


_OF_VALVE = PlantConstant("spool", ("command", "square"))
_OF_SPOOL = PlantConstant("spool", ("command",))


class NominalActuator(Section):
    """Double-rod actuator with a critically lapped servovalve; defaults are those of the paper."""

    piston_area: Annotated[float, SI("m^2", least=1e-7, most=1.0), PlantConstant()] = 633e-6
    """Annular area A of the piston in chamber 1 [m²]."""

    piston_area_2: Annotated[float, SI("m^2", least=1e-7, most=1.0)] | None = None
    """The same for chamber 2 [m²]; by default that of chamber 1."""

    chamber_volume: Annotated[float, SI("m^3", least=1e-8, most=1.0), PlantConstant()] = 280e-6
    """Volume V of chamber 1 with the piston at the centre, which is position zero by default [m³]."""

    chamber_volume_2: Annotated[float, SI("m^3", least=1e-8, most=1.0)] | None = None
    """The same for chamber 2 [m³]; by default that of chamber 1 in the ratio of the areas."""

    position_zero: Literal["centre", "retracted", "extended"] = "centre"
    """Where the measured position is zero. A positive position enlarges chamber 1. ``retracted``: at the end
    of the stroke with the smallest chamber 1; ``extended``: at that with the largest."""

    stroke: Annotated[float, SI("m", above=0, most=100.0)] | None = None
    """Stroke of the piston [m], for ``position_zero: retracted`` or ``extended``."""

    bulk_modulus: Annotated[float, SI("Pa", least=1e7, most=1e10), PlantConstant()] = 551e6
    """Bulk modulus β of the fluid [Pa]."""

    load_stiffness: Annotated[float, SI("N/m", above=0, most=1e12), PlantConstant("chambers", (1,))] = 150e3
    """Stiffness K_ex of the spring that loads the piston [N/m], used in place of the position."""

    flow_gain: Annotated[float, SI("m^1.5/kg^0.5", above=0, most=1.0), PlantConstant()] = 0.0292
    """Flow gain K_v of the valve [m^1.5/kg^0.5]."""

    area_gradient: Annotated[float, SI("m", above=0, most=10.0), PlantConstant()] = 20.75e-3
    """Orifice area gradient w [m]."""

    spool: Literal["measured", "command"] = "measured"
    """Spool position: ``measured``, or computed from the input voltage with the nominal valve
    (``command``)."""

    spool_gain: Annotated[float, SI("m/V", above=0, most=1.0), _OF_VALVE] = 22e-6
    """Spool position gain k_v [m/V], for ``spool: command``."""

    natural_frequency: Annotated[float, SI("Hz", least=0.1, most=1e5), _OF_SPOOL] = 175.0
    """Undamped natural frequency of the spool [Hz], for ``spool: command``."""

    damping_ratio: Annotated[float, SI("1", least=0.01, most=100.0), _OF_SPOOL] = 0.7
    """Damping ratio ξ of the spool [-], for ``spool: command``."""

    supply: Literal["auto", "measured", "nominal", "sum"] = "auto"
    """Supply pressure. ``measured``: its channel. ``nominal``: ``supply_pressure``. ``sum``: the
    median, in a stream the running mean, of P_1 + P_2 minus the return pressure, which assumes a matched
    valve and equal areas; with one pressure, twice its mean minus the pressure that balances the spring.
    ``auto``: measured, else ``sum`` with equal areas, else nominal."""

    supply_pressure: Annotated[
        float, SI("Pa", least=1e4, most=2e8), PlantConstant("supply", ("nominal",))
    ] = 17.2e6
    """Nominal supply pressure P_s [Pa]."""

    return_pressure: Annotated[float, SI("Pa", least=0, most=2e8)] = 0.0
    """Return pressure P_r [Pa]."""

    @model_validator(mode="after")
    def _has_stroke(self) -> Self:
        if self.position_zero != "centre" and self.stroke is None:
            raise ValueError(f"position_zero: {self.position_zero} needs the stroke of the piston")
        return self

    @property
    def areas(self) -> tuple[float, float]:
        """Piston areas of both chambers [m²]."""
        return self.piston_area, self.piston_area if self.piston_area_2 is None else self.piston_area_2

    @property
    def volumes(self) -> tuple[float, float]:
        """Volumes of both chambers with the piston at the centre [m³]."""
        (first, second), volume = self.areas, self.chamber_volume
        return volume, self.chamber_volume_2 or volume * (second / first)

    @property
    def channels(self) -> frozenset[Channel]:
        """Pressures, position, and what moves the valve."""
        shown_by = {"measured": {Channel.SPOOL_POSITION}, "command": {Channel.INPUT_VOLTAGE}}
        supply = {Channel.SUPPLY_PRESSURE} if self.supply == "measured" else set()
        motion = {Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION}
        return frozenset(motion | shown_by.get(self.spool, set()) | supply)

    @property
    def optional_channels(self) -> frozenset[Channel]:
        """The supply pressure, if `supply` allows it to be used."""
        return frozenset({Channel.SUPPLY_PRESSURE} if self.supply == "auto" else set())

    def position(self, records: RecordBatch) -> Array:
        """x_p from the centre [m], shape (n_record, n_time); NaN where a chamber would have no volume."""
        position = self._from_centre(records)
        first, second = self._volumes_at(position)
        is_impossible = (first <= 0.0) | (second <= 0.0)
        return np.where(is_impossible, np.nan, position) if is_impossible.any() else position

    def unfit_positions(self, records: RecordBatch) -> list[str | None]:
        """Why the positions of each record are impossible: a chamber would have no volume; None if it has."""
        if Channel.PISTON_POSITION not in records.channels:
            return [None] * records.n_record
        reasons: list[str | None] = [None] * records.n_record
        if self.stroke is not None:
            travel = np.ptp(records[Channel.PISTON_POSITION], axis=1)
            for row in np.flatnonzero(travel > self.stroke).tolist():
                reasons[row] = f"the piston travels {travel[row]:.3g} m, but its stroke is {self.stroke:g} m"
        for chamber, volume in enumerate(self._volumes_at(self._from_centre(records)), start=1):
            for row in np.flatnonzero(np.any(volume <= 0.0, axis=1)).tolist():
                reasons[row] = (
                    f"the volume of chamber {chamber} would be {1e6 * np.nanmin(volume[row]):.4g} cm^3:"
                    " state 'position_zero' and 'stroke', or the chamber volumes at position zero"
                )
        return reasons

    def _from_centre(self, records: RecordBatch) -> Array:
        measured = records[Channel.PISTON_POSITION]
        if self.position_zero == "centre" or self.stroke is None:
            return measured
        return measured + (-0.5 if self.position_zero == "retracted" else 0.5) * self.stroke

    def _volumes_at(self, position: Array) -> tuple[Array, Array]:
        (area_1, area_2), (first, second) = self.areas, self.volumes
        return first + area_1 * position, second - area_2 * position

    def spool_position(self, records: RecordBatch) -> Array:
        """x_v [m], shape (n_record, n_time).

        With a command, it is held between samples (zero-order hold) and the spool starts at rest.
        """
        if self.spool == "measured":
            return records[Channel.SPOOL_POSITION]
        command = records[Channel.INPUT_VOLTAGE]
        return self.follow_command(command, command[:, :1], None, records.sampling_frequency)[0]

    def spool_of_stream(self, chunk: RecordBatch, is_first: bool, state: Array) -> Array:
        """x_v of a chunk [m]; with a command, the spool is at rest under the first one of the stream.

        The state of the spool (n_record, 2) is updated in place.
        """
        if self.spool == "measured":
            return np.ascontiguousarray(chunk[Channel.SPOOL_POSITION])
        command = chunk[Channel.INPUT_VOLTAGE]
        if not chunk.n_time:
            return command
        before = None if is_first else state
        position, state[:] = self.follow_command(command, command[:, :1], before, chunk.sampling_frequency)
        return np.ascontiguousarray(position)

    def follow_command(
        self, command: Array, rest: Array, state: Array | None, sampling_frequency: float
    ) -> tuple[Array, Array]:
        """x_v (n_record, n_time) for a command held between samples, and the state (n_record, 2) after it.

        Without a state, the spool is initially at rest under the command `rest` (n_record, 1) [V].
        """
        from scipy.signal import lfilter

        numerator, denominator, at_rest = _held_command_filter(
            self.natural_frequency, self.damping_ratio, sampling_frequency
        )
        before = at_rest * rest if state is None else state
        position, after = lfilter(numerator, denominator, command, zi=before)
        return self.spool_gain * np.asarray(position), np.asarray(after)

    def supply_known_by(self, records: RecordBatch) -> Literal["measured", "nominal", "sum"]:
        """Resolve ``supply: auto`` for these records."""
        if self.supply != "auto":
            return self.supply
        if Channel.SUPPLY_PRESSURE in records.channels.keys() - records.relative:
            return "measured"
        return "sum" if self.areas[0] == self.areas[1] else "nominal"


@lru_cache(maxsize=64)
def _held_command_filter(
    natural_frequency: float, damping_ratio: float, sampling_frequency: float
) -> tuple[Array, Array, Array]:
    """Numerator and denominator of a second-order lag with zero-order hold, and its steady state."""
    from scipy.signal import cont2discrete, lfilter_zi

    rate = 2.0 * np.pi * natural_frequency
    continuous = np.array([rate**2]), np.array([1.0, 2.0 * damping_ratio * rate, rate**2])
    numerator, denominator, _ = cont2discrete(continuous, 1.0 / sampling_frequency)
    return numerator[0], denominator, lfilter_zi(numerator[0], denominator)
