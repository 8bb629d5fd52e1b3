"""Wrong calls of methods and sections, answered in one sentence."""

import pytest

import hydrofdi


@pytest.fixture(scope="module")
def simulated():
    return hydrofdi.simulate(duration="2 s")


def test_a_run_is_written_as_hdf5(simulated):
    with pytest.raises(hydrofdi.HydrofdiError):
        simulated.save("r.csv")


@pytest.mark.parametrize("keyword", ["supply_pressure", "fluid_bulk_modulus"])
def test_one_underscore_between_section_and_key_is_answered_with_two(keyword):
    wanted = keyword.replace("_", "__", 1)
    with pytest.raises(hydrofdi.HydrofdiError, match=f"did you mean '{wanted}'"):
        hydrofdi.simulate(**{keyword: "16 MPa"})
