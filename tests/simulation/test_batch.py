"""Batches of runs: lanes, spools, accuracy, and K_i for a flow."""

import math
import re

import numpy as np
import pytest

from hydrofdi.compilation.symbols import recorded
from hydrofdi.config import RunParameters, load_experiment
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.calibration import solve_leakage_coefficients
from hydrofdi.simulation.hydraulics import hydraulic_rates, lane_parameters
from hydrofdi.simulation.inputs import Drive, Spools, input_voltage
from hydrofdi.simulation.kernel import state_of
from hydrofdi.simulation.lanes import LANES, WIDTH, ModelOptions
from hydrofdi.transforms import detail_rms
from tests.machines import RIG, settings_of
from tests.simulation import reference

MOTION = "piston_position", "piston_velocity", "chamber_1_pressure", "chamber_2_pressure"
SIGNALS = ("input_voltage", "spool_position", *MOTION, "internal_leakage_flow")


def nominal(*settings):
    """The nominal actuator over 2 s, with settings."""
    return load_experiment(None, ["record.duration=2 s", *settings]).nominal_parameters


def signals(trajectory, row=0, names=SIGNALS):
    return np.array([getattr(trajectory, name)[row] for name in names])


@pytest.fixture(scope="module")
def mixed():
    """33 different runs with three different drives, and their signals one by one."""
    runs = [
        nominal(
            f"fluid.bulk_modulus={400 + 13 * k} MPa", f"friction.viscous={20 + 10 * k}",
            f"input.amplitude={(1, 2, -2)[k % 3]}", f"actuator.mass={8 + 0.3 * k}",
        )
        for k in range(33)
    ]  # fmt: skip
    coefficients = [1e-9 * k for k in range(33)]
    alone = [signals(simulate_batch([run], [K_i])) for run, K_i in zip(runs, coefficients, strict=True)]
    return runs, coefficients, alone


def test_a_run_has_the_same_bits_in_a_batch_of_any_size_in_any_lane_and_beside_one_that_diverges(mixed):
    runs, coefficients, alone = mixed
    for order in (range(5), range(16), np.random.default_rng(1).permutation(33)):
        batch = simulate_batch([runs[k] for k in order], [coefficients[k] for k in order])
        for row, k in enumerate(order):
            np.testing.assert_array_equal(signals(batch, row), alone[k])
    wrong = [nominal("fluid.bulk_modulus=1e13"), nominal("input.amplitude=10 V", "actuator.load_stiffness=0")]
    batch = simulate_batch([*wrong, *runs[:3]], [0.0, 0.0, *coefficients[:3]])
    assert [each.status for each in batch.outcomes] == ["diverged", "stroke_exceeded", "ok", "ok", "ok"]
    assert [bool(each.message) for each in batch.outcomes] == [True, True, False, False, False]
    for row in range(3):
        np.testing.assert_array_equal(signals(batch, row + 2), alone[row])


def test_a_run_has_the_same_bits_whether_it_shares_its_spool_and_however_long_its_record_is():
    run, other = nominal(), nominal("valve.natural_frequency=150 Hz")
    shared = simulate_batch([run, run], [0.0, 1e-8])
    apart = simulate_batch([other, run, run], [0.0, 0.0, 1e-8])
    for row in (0, 1):
        np.testing.assert_array_equal(signals(shared, row), signals(apart, row + 1))
    longer = simulate_batch([nominal("record.duration=3 s")], [1e-8])
    np.testing.assert_array_equal(signals(longer)[:, :1000], signals(shared, 1))


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


N_STEP, NOMINAL = 400, RunParameters().with_values({"input.period": 0.04})


def spool_motion(drives):
    """Voltage and stages of each drive, (n_drive, N_STEP, 5), in two chunks."""
    spools = Spools(drives, NOMINAL.record)
    chunks = []
    for first in (0, N_STEP // 2):
        voltage, stages = spools.advance(first, N_STEP // 2)
        chunks.append(np.concatenate([voltage[:, None], stages], axis=1))
    return np.concatenate(chunks).transpose(2, 0, 1)[spools.columns]


def test_a_spool_follows_its_own_voltage_with_the_same_bits_in_any_company_and_place():
    runs = [
        NOMINAL.with_values({
            "input.amplitude": (2.0, -1.0, 0.5)[k % 3], "input.shape": ("square", "sine")[k % 2],
            "valve.natural_frequency": 120.0 + 3.0 * k, "valve.largest_opening": (None, 3e-5)[k % 4 == 0],
            "valve.hysteresis": (0.0, 0.1)[k % 5 == 0],
        })
        for k in range(WIDTH + 5)
    ]  # fmt: skip
    drives = [Drive.of(run) for run in runs]
    alone = np.concatenate([spool_motion([drive]) for drive in drives])
    for order in (range(2), range(WIDTH), np.random.default_rng(2).permutation(len(drives))):
        np.testing.assert_array_equal(spool_motion([drives[k] for k in order]), alone[list(order)])
    expected = [input_voltage(run.input, run.record, np.arange(N_STEP)) for run in runs]
    np.testing.assert_allclose(alone[:, :, 0], expected, rtol=1e-15)
    assert np.all(np.abs(alone[4::4, -1, 1]) <= 3e-5)
    assert len({motion.tobytes() for motion in alone}) == len(drives)


def smooth_motion(step):
    smooth = "wavelet.levels=2", "friction.coulomb=0", "friction.breakaway=0", "friction.viscous=500"
    run = nominal("record.duration=0.2 s", f"record.step={step!r}", *smooth)
    return signals(simulate_batch([run], [0.0]), names=MOTION)


def test_halving_the_step_divides_the_error_by_sixteen_on_a_smooth_problem():
    exact = smooth_motion(1e-4 / 16)
    assert exact[1, 1:].min() > 0.0, "it does not turn"
    errors = [np.abs(smooth_motion(step) - exact).max(axis=1) for step in (4e-4, 2e-4, 1e-4)]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 4.0, atol=0.3)


def test_the_kernel_converges_to_radau_and_its_nominal_step_costs_little_of_any_detail_rms():
    run = nominal()
    x, _, spool, _, *pressures = reference.integrate(reference.printed_rates, run, 1e-8, 1e-9)
    for step, largest in ((1e-5, 5.0), (5e-5, 200.0), (1e-4, np.inf)):
        trajectory = simulate_batch([run.with_values({"record.step": step})], [1e-8])
        deviation = signals(trajectory, names=MOTION[2:]) - pressures
        assert np.abs(deviation).max() < largest
        np.testing.assert_allclose(trajectory.piston_position[0], x, atol=1e-6)
        np.testing.assert_allclose(trajectory.spool_position[0], spool, atol=1e-10)
    assert np.sqrt(np.mean(deviation**2)) < 200.0
    found, expected = (
        detail_rms(each, run.wavelet) for each in (trajectory.chamber_1_pressure[0], pressures[0])
    )
    np.testing.assert_allclose(found, expected, rtol=1e-3)


FLOWS = {"0.12 L/min": 2e-6, "0.89 L/min": 0.89e-3 / 60, "2 L/min": 2e-3 / 60}


def test_the_solved_coefficient_leaks_what_was_asked_for_and_does_not_depend_on_neighbours():
    """Nor on those whose flow no coefficient reaches, or whose records are longer."""
    conditions = [nominal(f"leakage.internal_flow={flow}") for flow in FLOWS]
    solutions = solve_leakage_coefficients(conditions)
    coefficients = [solution.coefficient for solution in solutions]
    flows = simulate_batch(conditions, coefficients).mean_internal_leakage_flow
    assert flows == pytest.approx(list(FLOWS.values()), rel=1e-8)
    assert coefficients == sorted(coefficients)
    other = nominal("leakage.internal_flow=1 L/min", "fluid.bulk_modulus=700 MPa")
    unreachable = [nominal(f"leakage.internal_flow={flow} L/min") for flow in (6, 10, 200, 7200)]
    long = nominal("leakage.internal_flow=0.12 L/min", "record.duration=3 s")
    together = solve_leakage_coefficients([long, other, *reversed(conditions), *unreachable])
    assert together[2:5] == solutions[::-1]
    assert together[0] == solve_leakage_coefficients([long])[0]
    assert all(math.isnan(solution.coefficient) for solution in together[5:])
    most = [solution.reachable_flow for solution in together[5:]]
    assert most == pytest.approx([most[0]] * 4, rel=0.02)
    assert 4e-3 / 60 < most[0] < 5e-3 / 60


def test_a_load_can_drive_the_leak_when_the_valve_is_shut():
    shut = nominal(
        *settings_of(RIG), "valve.edge_rounding=0.1 um", "leakage.internal_flow=0.5 L/min",
        "input.amplitude=0 V", "load.random_force=5 kN", "load.random_period=0.1 s",
    )  # fmt: skip
    (solution,) = solve_leakage_coefficients([shut])
    flow = simulate_batch([shut], [solution.coefficient]).mean_internal_leakage_flow[0]
    assert flow == pytest.approx(0.5e-3 / 60, rel=1e-8)
