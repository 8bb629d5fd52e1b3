import math

import pytest

from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.calibration import solve_leakage_coefficients

FLOWS = {"0.12 L/min": 2e-6, "0.89 L/min": 0.89e-3 / 60, "2 L/min": 2e-3 / 60}


@pytest.fixture(scope="module")
def conditions(parameters):
    return [parameters(f"leakage.internal_flow={flow}") for flow in FLOWS]


def test_the_solved_coefficient_leaks_what_was_asked_for(conditions):
    coefficients = [solution.coefficient for solution in solve_leakage_coefficients(conditions)]
    flows = simulate_batch(conditions, coefficients).mean_internal_leakage_flow
    assert flows == pytest.approx(list(FLOWS.values()), rel=1e-8)
    assert coefficients == sorted(coefficients)


def test_a_solution_does_not_depend_on_its_neighbours(conditions, parameters):
    others = [parameters("leakage.internal_flow=1 L/min", "fluid.bulk_modulus=700 MPa")]
    together = solve_leakage_coefficients([*others, *reversed(conditions)])[1:]
    alone = [solve_leakage_coefficients([condition])[0] for condition in reversed(conditions)]
    assert [solution.coefficient for solution in together] == [solution.coefficient for solution in alone]


def test_records_of_different_lengths_are_solved_each_on_its_own(conditions, parameters):
    long = parameters("leakage.internal_flow=0.12 L/min", "record.duration=3 s")
    mixed = solve_leakage_coefficients([conditions[0], long])
    assert mixed[0] == solve_leakage_coefficients([conditions[0]])[0]
    assert mixed[1] == solve_leakage_coefficients([long])[0]


@pytest.mark.parametrize("flow", ["500 L/min", "10 L/min"])
def test_a_flow_that_no_coefficient_reaches_has_no_solution_and_spares_the_others(
    conditions, parameters, flow
):
    unreachable = parameters(f"leakage.internal_flow={flow}")
    solutions = solve_leakage_coefficients([unreachable, conditions[0]])
    assert math.isnan(solutions[0].coefficient)
    assert solutions[0].reachable_flow < unreachable.leakage.internal_flow
    assert solutions[1] == solve_leakage_coefficients([conditions[0]])[0]


def test_the_most_that_an_actuator_leaks_does_not_hang_on_what_is_asked_for(parameters):
    asked = [parameters(f"leakage.internal_flow={flow} L/min") for flow in (6, 10, 200, 7200)]
    most = [solution.reachable_flow for solution in solve_leakage_coefficients(asked)]
    assert most == pytest.approx([most[0]] * 4, rel=0.02)
    assert 4e-3 / 60 < most[0] < 5e-3 / 60


def test_a_load_can_drive_the_leak_when_the_valve_is_shut(parameters):
    shut = parameters(
        "leakage.internal_flow=0.5 L/min", "input.amplitude=0 V", "load.random_force=5 kN",
        "load.random_period=0.1 s",
    )  # fmt: skip
    (solution,) = solve_leakage_coefficients([shut])
    flow = simulate_batch([shut], [solution.coefficient]).mean_internal_leakage_flow[0]
    assert flow == pytest.approx(0.5e-3 / 60, rel=1e-8)
