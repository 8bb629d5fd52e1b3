"""Units of indicators' variables, in the style of the other variables of a file."""

import h5py

from tests.conftest import sweep_in

MEASURED = """\
name: flows
record: {duration: 6 s}
store: {signals: none}
indicators: {dwt: {}, flow_balance: {}}
leakage: {internal_coefficient: 1e-8}
"""


def test_all_units_of_a_file_have_one_style(tmp_path):
    sweep = sweep_in(tmp_path, MEASURED)
    (path,) = sweep.directory.glob("*.h5")
    with h5py.File(path) as file:
        units = {name: str(variable.attrs.get("units", "")) for name, variable in file.items()}
    assert units["flow_balance.leakage"] == "m3 s-1"
    assert not [name for name, unit in units.items() if set("/^") & set(unit)]
