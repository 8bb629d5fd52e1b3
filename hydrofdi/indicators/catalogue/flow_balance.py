"""Internal leakage and bulk modulus from the balance of volume of the chambers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hydrofdi.evaluation.direction import Direction
from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.indicators.nominal_actuator import NominalActuator
from hydrofdi.physics.signed_root import signed_root
from hydrofdi.physics.valve import chamber_1_orifice_drop, chamber_2_orifice_drop
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI
from hydrofdi.transforms.regression import regress
from hydrofdi.transforms.weak_form import weak_integrals

_DIRECTION = {"internal_coefficient": Direction.RISING, "leakage": Direction.RISING}

P1, P2, X = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION


class FlowBalanceOptions(NominalActuator):
    """Options of `FlowBalance`: what is known of the actuator, and what is estimated."""

    chambers: Literal["both", "1"] = "both"
    """Whose balances are used; the pressures of both are needed either way."""

    estimate: tuple[Literal["flow_gain", "offset"], ...] = ()
    """What is estimated beside K_i and 1/β: a factor of the flow gain, and an offset of the spool. With one
    amplitude of the drive the factor can hardly be distinguished from the leak: see the condition number."""

    switching: Literal["left_out", "kept"] = "left_out"
    """What becomes of windows in which the spool moves by a fifth of its range from one sample to the next:
    samples do not tell what flows meanwhile."""

    half_window: Annotated[int, Field(strict=True, ge=2)] = 8
    """Half the length of a window [samples]; windows overlap by half."""

    reference_pressure: Annotated[float, SI("Pa", above=0)] = 8e6
    """Pressure difference at which the leakage flow is stated [Pa]."""


class FlowBalance(Indicator[FlowBalanceOptions]):
    """K_i and β that explain where the volume goes."""

    name = "flow_balance"
    version = 1
    summary = "Internal leakage and bulk modulus by least squares on the volume balance of the chambers."
    source = "weak form: Shinbrot, NACA TN 3288 (1954); balance: equations (5) to (8) and (11) of the paper"
    equation = (
        "∫φ(q_1 − A x_p') = K_i ∫φ sgn(ΔP) √abs(ΔP) + (1/β) ∫φ (V + A x_p) P_1', φ = sin²; chamber 2 alike"
    )
    caution = (
        "Noise of the pressures biases β upwards, by more than its stated deviation; K_i hardly moves. The "
        "deviations count what the fit leaves, not errors of the nominal model."
    )
    absence = "the balance does not determine a leakage"
    needs_scale = True
    Options = FlowBalanceOptions

    @property
    def channels(self) -> frozenset[Channel]:
        """Chamber pressures, position, and what moves the valve."""
        return frozenset({P1, P2, X}) | self.options.valve_channels

    @property
    def optional_channels(self) -> frozenset[Channel]:
        """The supply pressure."""
        return frozenset({Channel.SUPPLY_PRESSURE}) if self.options.supply == "auto" else frozenset()

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Estimates, each with its standard deviation."""
        at = f"at {self.options.reference_pressure / 1e6:g} MPa"
        estimates = {
            "internal_coefficient": ("m^3.5/kg^0.5", "coefficient K_i of the internal leakage"),
            "leakage": ("m^3/s", f"internal leakage flow {at}"),
            "bulk_modulus": ("Pa", "effective bulk modulus β"),
            "flow_gain": ("1", "flow gain of the valve over its nominal value"),
            "offset": ("m", "spool position at which the valve is closed"),
        }
        left_out = {"flow_gain", "offset"} - set(self.options.estimate)
        outputs = [
            output
            for name, (unit, text) in estimates.items()
            if name not in left_out
            for output in (
                Output(name, unit, text, direction=_DIRECTION.get(name)),
                Output.quality(f"{name}_error", unit, f"standard deviation of the {text}"),
            )
        ]
        return (*outputs, Output.quality("condition", "1", "condition number of the equations"))

    def obstacle(self, records: RecordBatch) -> str | None:
        """A record of too few windows."""
        n_window = records.n_time // self.options.half_window - 1
        return f"{max(n_window, 0)} windows are too few for a balance" if n_window < 8 else None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """In SI."""
        spool = self.options.spool_position(records)
        balances = list(self._balances(records, spool))
        columns = np.stack([columns for columns, _ in balances], axis=2)
        target = np.stack([target for _, target in balances], axis=1)
        if self.options.switching == "left_out":
            counts = ~_is_switching(spool, self.options.half_window)
            columns, target = columns * counts[:, None, None], target * counts[:, None]
        found = regress(columns, target)
        values, deviations = found.values.T, found.deviations.T
        root = np.sqrt(self.options.reference_pressure)
        numbers = {
            "internal_coefficient": (values[0], deviations[0]),
            "leakage": (values[0] * root, deviations[0] * root),
            "bulk_modulus": (1.0 / values[1], deviations[1] / values[1] ** 2),
        }
        for place, name in enumerate(self.options.estimate, 2):
            numbers[name] = values[place] + (1.0 if name == "flow_gain" else 0.0), deviations[place]
        named = {name: value for name, (value, _) in numbers.items()}
        errors = {f"{name}_error": error for name, (_, error) in numbers.items()}
        return named | errors | {"condition": found.condition}

    def _balances(self, records: RecordBatch, spool: Array) -> Iterator[tuple[Array, Array]]:
        """Columns (n_record, n_unknown, n_window) and target (n_record, n_window) [m³] of each chamber."""
        options, half = self.options, self.options.half_window
        frequency = records.sampling_frequency
        place, travel = weak_integrals(records[X], frequency, half, "value", "rate")
        place, speed = place * frequency / half, travel * frequency / half
        (leak,) = weak_integrals(signed_root(records[P1] - records[P2]), frequency, half, "value")
        for chamber, gradient in self._valve(records, spool):
            sign = 1.0 if chamber == 0 else -1.0
            area, volume = options.areas[chamber], options.volumes[chamber]
            (flow,) = weak_integrals(gradient * spool, frequency, half, "value")
            pressure = records[(P1, P2)[chamber]]
            rise, late_rise = weak_integrals(pressure, frequency, half, "rate", "late_rate")
            compressed = (volume + sign * area * place) * rise + sign * area * speed * late_rise
            columns = [leak, sign * compressed]
            if "flow_gain" in options.estimate:
                columns.append(-flow)
            if "offset" in options.estimate:
                columns.extend(weak_integrals(gradient, frequency, half, "value"))
            yield np.stack(columns, axis=1), flow - area * travel

    def _valve(self, records: RecordBatch, spool: Array) -> Iterator[tuple[int, Array]]:
        """Chamber, and the flow q_1 into or q_2 out of it over the spool position [m²/s]."""
        options, supply = self.options, self.options.supply_of(records)
        gain = options.flow_gain * options.area_gradient
        drop = chamber_1_orifice_drop(spool, records[P1], supply, options.return_pressure)
        yield 0, gain * signed_root(drop)
        if options.chambers == "both":
            drop = chamber_2_orifice_drop(spool, records[P2], supply, options.return_pressure)
            yield 1, gain * signed_root(drop)


def _is_switching(spool: Array, half: int) -> NDArray[np.bool_]:
    """Windows in which the spool jumps, shape (n_record, n_window)."""
    n_block = spool.shape[1] // half
    change = np.abs(np.diff(spool, axis=1, prepend=spool[:, :1]))[:, : n_block * half]
    jumps = change > 0.2 * np.ptp(spool, axis=1)[:, None]
    in_block = jumps.reshape(-1, n_block, half).any(axis=2)
    switching: NDArray[np.bool_] = in_block[:, :-1] | in_block[:, 1:]
    return switching
