"""Table 3 as it was before records and analyses were separated: `table3.json`, floats as hex.

Two types of processor differ in the last digits of a simulation, so the numbers are compared closely.
"""

import json
from pathlib import Path

import h5py
import numpy as np

REFERENCE = json.loads((Path(__file__).parent / "table3.json").read_text())


def floats(name):
    return np.vectorize(float.fromhex)(np.array(REFERENCE[name]))


def test_table_3_keeps_its_numbers(table3):
    with h5py.File(table3.file) as file:
        np.testing.assert_array_equal(file["internal_leakage_level"], floats("leakage_m3_per_s"))
        np.testing.assert_array_equal(file["bulk_modulus"], floats("bulk_modulus_Pa"))
        np.testing.assert_allclose(file["detail_rms"], floats("detail_rms_Pa"), rtol=1e-9)


def test_the_outputs_of_dwt_are_the_numbers_of_table_3(table3):
    with h5py.File(table3.file) as file:
        for level in range(1, 6):
            np.testing.assert_array_equal(file[f"dwt.d{level}"], file["detail_rms"][:, level - 1])
            np.testing.assert_array_equal(
                file[f"dwt.d{level}_phases"], file["phase_detail_rms"][..., level - 1]
            )
