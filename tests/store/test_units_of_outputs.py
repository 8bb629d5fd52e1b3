"""Units of indicators' variables, in the style of the other variables of a file."""

import h5py
import pytest

from hydrofdi.store.layout.outputs import cf_unit
from tests.conftest import sweep_in

MEASURED = """\
name: flows
record: {duration: 6 s}
store: {signals: none}
indicators: {dwt: {}, flow_balance: {}}
leakage: {internal_coefficient: 1e-8}
"""


@pytest.mark.parametrize(
    ("unit", "written"),
    [
        ("m^3.5/kg^0.5", "m3.5 kg-0.5"),
        ("m^3/s", "m3 s-1"),
        ("1/s", "s-1"),
        ("N·s/m", "N s m-1"),
        ("Pa", "Pa"),
        ("1", "1"),
    ],
)
def test_a_unit_is_written_as_powers(unit, written):
    assert cf_unit(unit) == written


def test_all_units_of_a_file_have_one_style(tmp_path):
    sweep = sweep_in(tmp_path, MEASURED)
    (path,) = sweep.directory.glob("*.h5")
    with h5py.File(path) as file:
        units = {name: str(variable.attrs.get("units", "")) for name, variable in file.items()}
    assert units["flow_balance.leakage"] == "m3 s-1"
    assert not [name for name, unit in units.items() if set("/^") & set(unit)]
