"""Laws of cylinders with unequal areas: statics, speeds, hydraulic mode, balances, printed equations."""

import math

import numpy as np
import pytest
from free_motion import FRICTIONLESS, free_motion, ring_down

from hydrofdi.config import RunParameters, load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.physics.hydraulic_mode import (
    damping_of_chamber_1,
    mode_damping_ratio,
    mode_frequency,
    softest_position,
)
from hydrofdi.quality.machine import hydraulic_mode, machine_figures
from hydrofdi.simulation.batch import simulate_batch
from tests.machines import GAP, LOOP, machine
from tests.simulation.reference import integrate, printed_rates

SIGNALS = "piston_position", "piston_velocity", "chamber_1_pressure", "chamber_2_pressure"
BORE, ROD = 1963e-6, 1348e-6
MACHINE = {
    "actuator.mass": 250.0, "actuator.piston_area": BORE, "actuator.piston_area_2": ROD,
    "actuator.chamber_volume": 443e-6, "actuator.chamber_volume_2": 320e-6,
    "actuator.load_stiffness": 0.0, "fluid.bulk_modulus": 1.2e9, "supply.pressure": 21e6,
    "friction.viscous": 2e3, "record.duration": 1.0, "input.period": 1.0,
}  # fmt: skip
"""Bore 50 mm, rod 28 mm, stroke 400 mm."""
ROW = machine(MACHINE)


HELD = {"load.constant_force": 3e3, "actuator.inclination": math.radians(-50.0), "friction.scale": 0.0}


def test_a_shut_cylinder_starts_in_equilibrium_with_weight_and_load() -> None:
    foundation = {"actuator.foundation_stiffness": 50e6, "actuator.foundation_damping": 20e3}
    batch = simulate_batch([ROW.with_values({**HELD, "input.amplitude": 0.0, **foundation})], [0.0])
    assert np.abs(batch.piston_position).max() < 1e-12
    force = BORE * batch.chamber_1_pressure - ROD * batch.chamber_2_pressure
    np.testing.assert_allclose(force, 3e3 - 250.0 * 9.80665 * math.sin(math.radians(50.0)), atol=1e-3)


def test_a_controlled_cylinder_at_rest_has_its_static_pressures_whether_its_edges_are_matched_or_not() -> (
    None
):
    control = {"control.amplitude": 0.0, "control.integral_gain": 1e3, "record.duration": 20.0}
    matched = {f"{edge}_2_edge.flow_gain_ratio": ROD / BORE for edge in ("supply", "return")}
    valves = ({"valve.lap_leakage": 2e-12}, {"valve.lap": -4e-6}, {"valve.lap": -4e-6, **matched})
    runs = [machine(MACHINE | HELD | control | valve, LOOP) for valve in valves]
    batch, (first, second) = simulate_batch(runs, [0.0] * 3), runs[0].start_pressures
    assert np.abs(batch.piston_velocity[:, -500:]).max() < 1e-7
    np.testing.assert_allclose(batch.chamber_1_pressure[:, -1], first, rtol=2e-3)
    np.testing.assert_allclose(batch.chamber_2_pressure[:, -1], second, rtol=2e-3)


def test_the_mode_has_its_frequency_over_the_stroke_and_its_damping_with_unequal_chambers() -> None:
    """Weight balances equal pressures at the mean, where clearances and a laminar gap carry no flow."""
    step, clearance, extra, coefficient, angle = 2e-5, 0.5e-12, 0.8e-12, 5e-9, math.radians(80.0)
    mean = 250.0 * 9.80665 * math.sin(angle) / (BORE - ROD)
    softest = softest_position((BORE, ROD), (443e-6, 320e-6))
    values = MACHINE | {
        **FRICTIONLESS, "friction.viscous": 500.0, "supply.pressure": 2.0 * mean,
        "actuator.inclination": angle, "valve.lap_leakage": clearance, "supply_2_edge.lap_leakage": extra,
        "return_2_edge.lap_leakage": extra, "leakage.internal_coefficient": coefficient,
    }  # fmt: skip
    edges = 2.0 * clearance, 2.0 * (clearance + extra)

    def formula(x: float) -> tuple[float, float]:
        volumes = 443e-6 + BORE * x, 320e-6 - ROD * x
        omega = mode_frequency(1.2e9, (BORE, ROD), volumes, 250.0, 0.0)
        flows = damping_of_chamber_1((BORE, ROD), volumes, edges, coefficient / math.sqrt(10e6))
        return omega, mode_damping_ratio(omega, 1.2e9, volumes[0], 250.0, 500.0, *flows)

    positions = [0.0, softest, -0.15, 0.15]
    start = [{"position": x, "velocity": 1e-4, "pressure_1": mean, "pressure_2": mean} for x in positions]
    motion = free_motion([values] * len(positions), start, [0.0] * len(positions), 0.3, step, GAP)
    measured = [ring_down(velocity, step) for velocity in motion["velocity"]]
    np.testing.assert_allclose(measured, [formula(x) for x in positions], rtol=0.02)
    assert min(formula(softest - 1e-3), formula(softest + 1e-3)) > formula(softest)


def test_figures_of_the_machine_are_those_of_its_records() -> None:
    run = ROW.with_values({
        **HELD, "actuator.stroke": 0.4, "valve.lap_leakage": 1e-14, "record.duration": 2.0,
        "input.period": 2.0, "friction.viscous": 0.0,
    })  # fmt: skip
    figures, batch = machine_figures(run), simulate_batch([run], [0.0])
    extending, retracting = (batch.piston_velocity[0, k - 100 : k].mean() for k in (500, 1000))
    assert extending == pytest.approx(figures["speed_extending"], rel=0.01)
    assert -retracting == pytest.approx(figures["speed_retracting"], rel=0.01)
    assert figures["frequency_centred"] == pytest.approx(hydraulic_mode(run, batch).frequency, rel=1e-12)
    ends = figures["frequency_retracted"], figures["frequency_extended"]
    assert figures["least_frequency"] < figures["frequency_centred"] < min(ends)
    # The gain is the slope of the load pressure over a small spool travel of a blocked piston.
    blocked = MACHINE | HELD | {
        "valve.lap_leakage": 1e-12, "actuator.mass": 1e15, "actuator.inclination": 1e-30,
    }  # fmt: skip
    pressures = free_motion([blocked] * 2, [{}, {}], [1e-9, -1e-9], 2.0, 1e-4)
    load = (pressures["pressure_1"] - ROD / BORE * pressures["pressure_2"])[:, -1]
    gain = machine_figures(RunParameters().with_values(blocked))["pressure_gain"]
    assert (load[0] - load[1]) / 2e-9 * 22e-6 == pytest.approx(gain, rel=0.02)


def test_the_extremes_of_the_stroke_hold() -> None:
    far = {"input.amplitude": 5.0, "record.duration": 4.0, "input.period": 8.0, "actuator.stroke": 0.3}
    stopped = {"actuator.end_stop_stiffness": 20e6}
    batch = simulate_batch([ROW.with_values(far), ROW.with_values(far | stopped)], [0.0] * 2)
    assert [outcome.status for outcome in batch.outcomes] == ["stroke_exceeded", "ok"]
    assert 0.15 < batch.piston_position[1].max() < 0.153


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("stroke: 0.9 m", "actuator"), ("inclination: 90", "actuator.inclination"),
        ("end_stops: elastic, piston_area_2: 700 mm², chamber_volume_2: 100 cm³", "actuator"),
        ("piston_area_2: 0", "actuator.piston_area_2"),
    ],
)  # fmt: skip
def test_impossible_cylinders_are_mistakes_with_their_place(experiment_file, text: str, key: str) -> None:
    file = experiment_file(f"name: rod\nactuator: {{{text}}}\n")
    with pytest.raises(ConfigError) as error:
        load_experiment(file)
    (mistake,) = error.value.mistakes
    assert (mistake.origin, mistake.where) == (f"{file}:2", key)


def test_the_printed_equations_with_two_areas_agree_on_random_machines() -> None:
    draw = np.random.default_rng(27).uniform
    for _ in range(2):
        area, ratio, stroke = draw(0.5e-3, 4e-3), draw(0.4, 0.95), draw(0.2, 0.5)
        run = ROW.with_values({
            "actuator.mass": draw(30.0, 600.0), "actuator.piston_area": area,
            "actuator.piston_area_2": ratio * area, "actuator.stroke": stroke,
            "actuator.chamber_volume": draw(30e-6, 100e-6) + 0.5 * stroke * area,
            "actuator.chamber_volume_2": draw(30e-6, 100e-6) + 0.5 * stroke * ratio * area,
            "actuator.inclination": draw(-0.5 * math.pi, 0.5 * math.pi),
            "load.constant_force": draw(-0.2, 0.2) * 10e6 * area, "fluid.bulk_modulus": draw(0.7e9, 1.6e9),
            "friction.viscous": draw(500.0, 5e3), "input.amplitude": draw(1.0, 3.0), "input.period": 0.25,
            "record.duration": 0.5, "supply.pressure": draw(12e6, 28e6),
            "supply.return_pressure": draw(0.0, 0.5e6),
        })  # fmt: skip
        leak = draw(0.0, 2e-8)
        batch = simulate_batch([run], [leak])
        x, v, _, _, p1, p2 = integrate(printed_rates, run, leak, 1e-7)
        flow = leak * np.sign(p1 - p2) * np.sqrt(np.abs(p1 - p2))
        for signal, expected in zip((*SIGNALS, "internal_leakage_flow"), (x, v, p1, p2, flow), strict=True):
            assert np.abs(getattr(batch, signal)[0] - expected).max() < 1e-3 * expected.std(), signal
