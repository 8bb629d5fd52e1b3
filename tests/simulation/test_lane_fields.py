"""Lists that name the same things are tied to each other."""

import dataclasses
from operator import attrgetter

import numpy as np

from hydrofdi.config import RunParameters
from hydrofdi.simulation.balances import Trajectory
from hydrofdi.simulation.kernels.hydraulics import State
from hydrofdi.simulation.kernels.kernel import keep_state, state_of, take_sample
from hydrofdi.simulation.kernels.lanes import (
    LANES,
    LEAKAGE,
    PARAMETERS,
    SAMPLED,
    STATES,
    ModelOptions,
    pack_lanes,
)
from hydrofdi.store.layout import names

EVERYTHING = ModelOptions()._replace(supply_droop=True, bristles=True, closed_loop=True)


def distinct_lanes():
    """Lanes of which every field has a number of its own."""
    lanes = np.zeros(1, LANES)
    for half in ("left", "right"):
        for number, field in enumerate(LANES[half].names, 1):
            lanes[half][field] = number
    return lanes["left"][0], dict(
        zip(LANES["left"].names, range(1, 1 + len(LANES["left"].names)), strict=True)
    )


def test_a_lane_field_holds_the_parameter_that_it_names():
    run = RunParameters()
    lanes = pack_lanes([run], [1e-8])
    for field, path in PARAMETERS.items():
        np.testing.assert_array_equal(lanes["left"][field][0], attrgetter(path)(run))
    np.testing.assert_array_equal(lanes["left"][LEAKAGE][0], 1e-8)


def test_states_are_read_and_kept_under_their_names():
    half, numbers = distinct_lanes()
    half = half.view(np.recarray)
    state = state_of(half, 5)
    assert state._asdict() == {name: numbers[name] for name in STATES}
    keep_state(half, 7, State(*(-value for value in state)), EVERYTHING)
    assert [half[name][7] for name in STATES] == [-numbers[name] for name in STATES]


def test_sampled_rows_are_the_fields_that_they_are_named_after():
    half, numbers = distinct_lanes()
    sample = np.zeros((len(SAMPLED), 16))
    take_sample(half.view(np.recarray), sample, 0, EVERYTHING)
    expected = [numbers["spool_1" if name == "spool_position" else name] for name in SAMPLED]
    np.testing.assert_array_equal(sample[:, 0], expected)


def test_every_signal_of_the_file_is_one_of_the_trajectory():
    signals = {variable.name for variable in names.stored_variables("all") if variable.is_signal}
    fields = {field.name for field in dataclasses.fields(Trajectory)}
    assert signals <= fields | {name for name in dir(Trajectory) if not name.startswith("_")}
