import numpy as np
import pytest

from hydrofdi.indicators.catalogue.emd import empirical_modes
from indicators.laws import (
    SAMPLING_FREQUENCY,
    noise,
    ringing,
    values,
)


def test_two_tones_are_two_modes():
    time = np.arange(5000) / SAMPLING_FREQUENCY
    fast, slow = 3e5 * np.sin(2 * np.pi * 60.0 * time), 5e5 * np.sin(2 * np.pi * 7.0 * time)
    found = values("emd", 8e6 + fast + slow)
    assert found["imf1"] == pytest.approx(3e5, rel=0.01)
    assert found["imf2"] == pytest.approx(5e5, rel=0.02)
    assert found["imf3"] < 5e4  # from the ends of the record


def test_modes_oscillate_about_zero_and_what_they_leave_is_slower():
    record = ringing(1, 1)[0]
    modes = empirical_modes(record, 4, 10)
    crossings = [np.count_nonzero(np.diff(np.sign(mode))) for mode in modes]
    assert crossings == sorted(crossings, reverse=True)
    for mode in modes[:3]:
        assert abs(mode.mean()) < 0.1 * mode.std()
    rest = record - modes.sum(axis=0)
    assert np.count_nonzero(np.diff(np.sign(np.diff(rest)))) < crossings[3]


def test_a_record_and_its_mirror_image_have_the_same_modes():
    record = ringing(2, 1)
    one, other = values("emd", record), values("emd", record[:, ::-1].copy())
    for key in one:
        assert one[key] == pytest.approx(other[key][0], rel=1e-6)


def test_the_first_mode_of_white_noise_has_the_larger_part_of_it():
    found = values("emd", noise(3, (4, 4000), size=4.0, mean=0.0))
    shares = [np.mean(found[f"imf{mode}"] ** 2) / 2.0 / 16.0 for mode in (1, 2, 3)]
    assert 0.4 < shares[0] < 0.75
    assert shares[0] > 2.0 * shares[1] > 2.0 * shares[2]


@pytest.mark.parametrize(
    "record", [np.full(500, 8e6), np.linspace(1e6, 9e6, 500), np.r_[np.ones(250), np.zeros(250)]]
)
def test_what_does_not_oscillate_has_no_modes(record):
    assert all(amplitude == 0.0 for amplitude in values("emd", record).values())


def test_a_single_oscillation_ends():
    found = values("emd", 8e6 + 1e6 * np.sin(np.linspace(0.0, 2.0 * np.pi, 400)), modes=10, siftings=100)
    assert all(np.isfinite(amplitude) for amplitude in found.values())


def test_the_first_mode_is_about_that_of_pyemd():
    library = pytest.importorskip("PyEMD")
    record = ringing(7, 1, 2000)
    theirs = library.EMD(FIXE=10)(record[0], max_imf=1)[:1]
    ours = empirical_modes(record[0], 1, 10)
    assert np.std(ours - theirs) < 0.02 * np.std(theirs)
