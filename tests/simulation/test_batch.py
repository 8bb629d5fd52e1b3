"""Batches of runs: lanes, spools, accuracy, and K_i for a flow."""

import dataclasses
import math
import re
from operator import attrgetter

import numpy as np
import pytest

from hydrofdi.compilation.symbols import recorded
from hydrofdi.config import RunParameters, load_experiment
from hydrofdi.simulation.balances import Trajectory
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.calibration import solve_leakage_coefficients
from hydrofdi.simulation.hydraulics import State, hydraulic_rates, lane_parameters
from hydrofdi.simulation.inputs import Drive, Spools, input_voltage
from hydrofdi.simulation.kernel import keep_state, state_of, take_sample
from hydrofdi.simulation.lanes import (
    LANES,
    LEAKAGE,
    OPTIONAL,
    PARAMETERS,
    SAMPLED,
    STATES,
    WIDTH,
    ModelOptions,
    pack_lanes,
)
from hydrofdi.store import names
from hydrofdi.transforms import detail_rms
from tests.machines import RIG, settings_of
from tests.simulation import reference

SIGNALS = (
    "input_voltage", "spool_position", "piston_position", "piston_velocity",
    "chamber_1_pressure", "chamber_2_pressure", "internal_leakage_flow",
)  # fmt: skip


def signals(trajectory, row=0):
    return np.array([getattr(trajectory, name)[row] for name in SIGNALS])


@pytest.fixture(scope="module")
def mixed(parameters):
    """33 different runs with three different drives, and their signals one by one."""
    runs = [
        parameters(
            f"fluid.bulk_modulus={400 + 13 * k} MPa", f"friction.viscous={20 + 10 * k}",
            f"input.amplitude={(1, 2, -2)[k % 3]}", f"actuator.mass={8 + 0.3 * k}",
        )
        for k in range(33)
    ]  # fmt: skip
    coefficients = [1e-9 * k for k in range(33)]
    alone = [signals(simulate_batch([run], [K_i])) for run, K_i in zip(runs, coefficients, strict=True)]
    return runs, coefficients, alone


def test_a_run_has_the_same_bits_in_a_batch_of_any_size_and_in_any_lane(mixed):
    runs, coefficients, alone = mixed
    for order in (range(5), range(16), np.random.default_rng(1).permutation(33)):
        batch = simulate_batch([runs[k] for k in order], [coefficients[k] for k in order])
        for row, k in enumerate(order):
            np.testing.assert_array_equal(signals(batch, row), alone[k])


def test_a_run_has_the_same_bits_whether_it_shares_its_spool_or_not(parameters):
    run, other = parameters(), parameters("valve.natural_frequency=150 Hz")
    shared = simulate_batch([run, run], [0.0, 1e-8])
    apart = simulate_batch([other, run, run], [0.0, 0.0, 1e-8])
    for row in (0, 1):
        np.testing.assert_array_equal(signals(shared, row), signals(apart, row + 1))


def test_a_run_that_diverges_leaves_its_neighbours_as_they_are(mixed, parameters):
    runs, coefficients, alone = mixed
    batch = simulate_batch([parameters("fluid.bulk_modulus=1e13"), *runs[:3]], [0.0, *coefficients[:3]])
    assert [outcome.status for outcome in batch.outcomes] == ["diverged", "ok", "ok", "ok"]
    for row in range(3):
        np.testing.assert_array_equal(signals(batch, row + 1), alone[row])


def test_a_longer_record_begins_with_the_shorter_one(parameters):
    short, long = (simulate_batch([parameters(f"record.duration={t} s")], [1e-8]) for t in (2, 3))
    np.testing.assert_array_equal(signals(long)[:, :1000], signals(short))


@pytest.mark.parametrize(
    ("settings", "status"),
    [
        (["actuator.mass=0.1 g"], "diverged"),
        (["input.amplitude=10 V", "actuator.load_stiffness=0"], "stroke_exceeded"),
    ],
)
def test_a_run_that_goes_wrong_ends_with_a_class_and_a_sentence(parameters, settings, status):
    (outcome,) = simulate_batch([parameters(*settings)], [0.0]).outcomes
    assert outcome.status == status
    assert outcome.message


ALL = ModelOptions(*[True] * len(ModelOptions._fields))._replace(friction_law="lugre")
OTHER_LAWS = ALL._replace(laminar_leakage=False, bristles=False, lapped_valve=False, friction_law="smooth")


@pytest.mark.parametrize(
    "options",
    [pytest.param(ALL, id="all"), pytest.param(OTHER_LAWS, id="other laws", marks=pytest.mark.long)],
)
def test_no_equation_of_the_lanes_calls_the_c_library(options):
    def rates(lanes, out):
        p = lane_parameters(lanes[0].left, 0, 1.0, 1.0, options)
        out[0] = hydraulic_rates(state_of(lanes[0].left, 0), 1.0, 1.0, p, options).velocity

    calls = re.findall(r"call [^@]*@\"?([\w.]+)", recorded(rates, (np.zeros(1, LANES), np.zeros(1)), "rates"))
    assert calls
    assert {name.split(".")[0] for name in calls} == {"llvm"}
    assert not {name.split(".")[1] for name in calls} & {"exp", "log", "pow", "sin", "cos"}


N_STEP = 400
NOMINAL = RunParameters().with_values({"input.period": 0.04})
RUNS = [
    NOMINAL.with_values({
        "input.amplitude": (2.0, -1.0, 0.5)[k % 3],
        "input.shape": ("square", "sine")[k % 2],
        "valve.natural_frequency": 120.0 + 3.0 * k,
        "valve.largest_opening": (None, 3e-5)[k % 4 == 0],
        "valve.hysteresis": (0.0, 0.1)[k % 5 == 0],
    })
    for k in range(WIDTH + 5)
]  # fmt: skip
DRIVES = [Drive.of(run) for run in RUNS]


def spool_motion(drives):
    """Voltage and stages of each drive, (n_drive, N_STEP, 5), in two chunks."""
    spools = Spools(drives, NOMINAL.record)
    chunks = []
    for first in (0, N_STEP // 2):
        voltage, stages = spools.advance(first, N_STEP // 2)
        chunks.append(np.concatenate([voltage[:, None], stages], axis=1))
    return np.concatenate(chunks).transpose(2, 0, 1)[spools.columns]


@pytest.fixture(scope="module")
def alone():
    return np.concatenate([spool_motion([drive]) for drive in DRIVES])


def test_a_spool_has_the_same_bits_in_company_of_any_size_and_in_any_place(alone):
    for n_drive in (2, WIDTH):
        np.testing.assert_array_equal(spool_motion(DRIVES[:n_drive]), alone[:n_drive])
    order = np.random.default_rng(2).permutation(len(DRIVES))
    np.testing.assert_array_equal(spool_motion([DRIVES[k] for k in order]), alone[order])


def test_each_spool_follows_its_own_voltage(alone):
    steps = np.arange(N_STEP)
    expected = [input_voltage(run.input, run.record, steps) for run in RUNS]
    np.testing.assert_allclose(alone[:, :, 0], expected, rtol=1e-15)
    assert np.all(np.abs(alone[4::4, -1, 1]) <= 3e-5)
    assert len({motion.tobytes() for motion in alone}) == len(DRIVES)


def test_a_lane_field_holds_the_parameter_that_it_names():
    run = RunParameters()
    lanes = pack_lanes([run], [1e-8])
    for field, path in PARAMETERS.items():
        np.testing.assert_array_equal(lanes["left"][field][0], attrgetter(path)(run))
    np.testing.assert_array_equal(lanes["left"][LEAKAGE][0], 1e-8)


def test_states_are_read_kept_and_sampled_under_their_names():
    names, everything = (
        LANES["left"].names,
        ModelOptions(closed_loop=True, **dict.fromkeys(OPTIONAL.values(), True)),
    )
    numbers, half = {name: number for number, name in enumerate(names, 1)}, np.zeros(1, LANES)["left"][0]
    for name, number in numbers.items():
        half[name] = number
    half = half.view(np.recarray)
    state, sample = state_of(half, 5), np.zeros((len(SAMPLED), 16))
    assert state._asdict() == {name: numbers[name] for name in STATES}
    take_sample(half, sample, 0, everything)
    expected = [numbers["spool_1" if name == "spool_position" else name] for name in SAMPLED]
    np.testing.assert_array_equal(sample[:, 0], expected)
    keep_state(half, 7, State(*(-value for value in state)), everything)
    assert [half[name][7] for name in STATES] == [-numbers[name] for name in STATES]


def test_every_signal_of_the_file_is_one_of_the_trajectory():
    signals = {variable.name for variable in names.stored_variables("all") if variable.is_signal}
    fields = {field.name for field in dataclasses.fields(Trajectory)}
    assert signals <= fields | {name for name in dir(Trajectory) if not name.startswith("_")}


SMOOTH = (
    "record.duration=0.2 s", "wavelet.levels=2", "friction.coulomb=0", "friction.breakaway=0",
    "friction.viscous=500",
)  # fmt: skip


def smooth_record(parameters, step):
    run = parameters(*SMOOTH, f"record.step={step!r}")
    trajectory = simulate_batch([run], [0.0])
    assert trajectory.piston_velocity[0, 1:].min() > 0.0
    names = ("piston_position", "piston_velocity", "chamber_1_pressure", "chamber_2_pressure")
    return np.array([getattr(trajectory, name)[0] for name in names])


def test_halving_the_step_divides_the_error_by_sixteen_on_a_smooth_problem(parameters):
    exact = smooth_record(parameters, 1e-4 / 16)
    errors = [np.abs(smooth_record(parameters, step) - exact).max(axis=1) for step in (4e-4, 2e-4, 1e-4)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, 4.0, atol=0.3)


@pytest.fixture(scope="module")
def radau():
    """Parameters over 2 s with a leak, K_i, and their states by Radau at a relative tolerance of 1e-9."""
    run = load_experiment(None, ["record.duration=2 s"]).nominal_parameters
    return run, 1e-8, reference.integrate(reference.printed_rates, run, 1e-8, 1e-9)


def deviations(radau, step):
    run, K_i, states = radau
    trajectory = simulate_batch([run.with_values({"record.step": step})], [K_i])
    pressures = np.array([trajectory.chamber_1_pressure[0], trajectory.chamber_2_pressure[0]])
    return trajectory, np.abs(pressures - states[4:])


def test_the_kernel_converges_to_radau(radau):
    assert deviations(radau, 1e-5)[1].max() < 5.0
    trajectory, deviation = deviations(radau, 5e-5)
    assert deviation.max() < 200.0
    np.testing.assert_allclose(trajectory.piston_position[0], radau[2][0], atol=1e-6)
    np.testing.assert_allclose(trajectory.spool_position[0], radau[2][2], atol=1e-11)


def test_the_nominal_step_costs_less_than_a_thousandth_of_any_detail_rms(radau):
    trajectory, deviation = deviations(radau, 1e-4)
    assert np.sqrt(np.mean(deviation**2)) < 200.0
    wavelet = radau[0].wavelet
    expected = detail_rms(radau[2][4], wavelet)
    np.testing.assert_allclose(detail_rms(trajectory.chamber_1_pressure[0], wavelet), expected, rtol=1e-3)


FLOWS = {"0.12 L/min": 2e-6, "0.89 L/min": 0.89e-3 / 60, "2 L/min": 2e-3 / 60}


@pytest.fixture(scope="module")
def conditions(parameters):
    return [parameters(f"leakage.internal_flow={flow}") for flow in FLOWS]


@pytest.fixture(scope="module")
def solutions(conditions):
    return solve_leakage_coefficients(conditions)


def test_the_solved_coefficient_leaks_what_was_asked_for(conditions, solutions):
    coefficients = [solution.coefficient for solution in solutions]
    flows = simulate_batch(conditions, coefficients).mean_internal_leakage_flow
    assert flows == pytest.approx(list(FLOWS.values()), rel=1e-8)
    assert coefficients == sorted(coefficients)


def test_a_solution_does_not_depend_on_its_neighbours(conditions, solutions, parameters):
    """Nor on those whose flow no coefficient reaches, or whose records are longer."""
    other = parameters("leakage.internal_flow=1 L/min", "fluid.bulk_modulus=700 MPa")
    unreachable = [parameters(f"leakage.internal_flow={flow}") for flow in ("500 L/min", "10 L/min")]
    long = parameters("leakage.internal_flow=0.12 L/min", "record.duration=3 s")
    together = solve_leakage_coefficients([long, *unreachable, other, *reversed(conditions)])
    assert together[4:] == solutions[::-1]
    assert together[0] == solve_leakage_coefficients([long])[0]
    for run, solution in zip(unreachable, together[1:3], strict=True):
        assert math.isnan(solution.coefficient)
        assert solution.reachable_flow < run.leakage.internal_flow


def test_the_most_that_an_actuator_leaks_does_not_hang_on_what_is_asked_for(parameters):
    asked = [parameters(f"leakage.internal_flow={flow} L/min") for flow in (6, 10, 200, 7200)]
    most = [solution.reachable_flow for solution in solve_leakage_coefficients(asked)]
    assert most == pytest.approx([most[0]] * 4, rel=0.02)
    assert 4e-3 / 60 < most[0] < 5e-3 / 60


def test_a_load_can_drive_the_leak_when_the_valve_is_shut(parameters):
    shut = parameters(
        *settings_of(RIG), "valve.edge_rounding=0.1 um", "leakage.internal_flow=0.5 L/min",
        "input.amplitude=0 V", "load.random_force=5 kN", "load.random_period=0.1 s",
    )  # fmt: skip
    (solution,) = solve_leakage_coefficients([shut])
    flow = simulate_batch([shut], [solution.coefficient]).mean_internal_leakage_flow[0]
    assert flow == pytest.approx(0.5e-3 / 60, rel=1e-8)
