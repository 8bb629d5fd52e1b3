"""What lets the compiler advance the lanes by SIMD instructions."""

import re

import numba
import pytest

from hydrofdi.compilation.compiling import dispatcher
from hydrofdi.physics.equation import FAST_MATH
from hydrofdi.physics.friction import choice_of_law
from hydrofdi.simulation.kernels.hydraulics import LaneParameters, State, hydraulic_rates
from hydrofdi.simulation.kernels.lanes import ModelOptions

ALL = ModelOptions(*[True] * len(ModelOptions._fields))._replace(friction_law=choice_of_law("lugre"))
OTHER_LAWS = ALL._replace(
    laminar_leakage=None, bristles=None, lapped_valve=None, friction_law=choice_of_law("smooth")
)
CALL = re.compile(r"@\"?(?:llvm\.)?(exp2?|log2?|log10|pow|sin|cos|tan|tanh|fmod|frexp|ldexp)\b")


@pytest.mark.parametrize("options", [ALL, OTHER_LAWS], ids=["all", "other laws"])
def test_no_equation_of_the_lanes_calls_the_c_library(options):
    numbers = [1.0] * len(LaneParameters._fields)
    arguments = State(*[1.0] * len(State._fields)), 1.0, 1.0, LaneParameters(*numbers), options
    rates = dispatcher(hydraulic_rates, fastmath=FAST_MATH)
    signature = tuple(map(numba.typeof, arguments))
    rates.compile(signature)
    assert set(CALL.findall(rates.inspect_llvm(signature))) == set()
