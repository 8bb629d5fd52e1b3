import numpy as np
import pytest
import pywt

from indicators.laws import assert_batch_has_no_effect, assert_unit_scales, noise, obstacle, ringing, values


@pytest.mark.parametrize("wavelet", ["db8", "haar", "sym5"])
def test_coefficients_are_those_of_pywavelets(wavelet):
    record = ringing(1, 1, 2048)
    found = values("modwt", record, wavelet=wavelet, levels=4, boundary="circle")
    for level, (approximation, detail) in zip(range(4, 0, -1), pywt.swt(record[0], wavelet, 4), strict=True):
        np.testing.assert_allclose(found[f"d{level}"], np.sqrt(np.mean(detail**2)), rtol=1e-9)
        np.testing.assert_allclose(found[f"a{level}"], np.sqrt(np.mean(approximation**2)), rtol=1e-9)


def test_without_the_boundary_only_coefficients_inside_the_record_count():
    record = ringing(2, 1, 1024)
    found = values("modwt", record, levels=3, boundary="left_out")
    low, high = (np.array(taps) for taps in pywt.Wavelet("db8").filter_bank[:2])
    approximation = record[0]
    for level in range(1, 4):
        spread = [np.zeros(15 * 2 ** (level - 1) + 1) for _ in range(2)]
        for taps, filter_ in zip(spread, (low, high), strict=True):
            taps[:: 2 ** (level - 1)] = filter_
        detail = np.convolve(approximation, spread[1], "valid")
        approximation = np.convolve(approximation, spread[0], "valid")
        np.testing.assert_allclose(found[f"d{level}"], np.sqrt(np.mean(detail**2)), rtol=1e-9)
        np.testing.assert_allclose(found[f"a{level}"], np.sqrt(np.mean(approximation**2)), rtol=1e-9)


@pytest.mark.parametrize("n_time", [3000, 3001])
def test_levels_share_the_energy_of_the_record(n_time):
    record = ringing(3, 1, n_time)
    found = values("modwt", record, boundary="circle")
    energy = sum(found[f"d{level}"] ** 2 / 2**level for level in range(1, 6)) + found["a5"] ** 2 / 2**5
    np.testing.assert_allclose(energy, np.mean(record**2), rtol=1e-12)


def test_a_circular_shift_changes_nothing():
    record = ringing(4, 1, 2500)
    one, other = (values("modwt", each, boundary="circle") for each in (record, np.roll(record, 777, axis=1)))
    for key in one:
        np.testing.assert_allclose(one[key], other[key], rtol=1e-9)


@pytest.mark.parametrize("boundary", ["circle", "left_out"])
def test_white_noise_has_its_standard_deviation_at_each_level(boundary):
    found = values("modwt", noise(5, (8, 20_000), size=3.0, mean=0.0), boundary=boundary)
    for level in range(1, 6):
        assert np.sqrt(np.mean(found[f"d{level}"] ** 2)) == pytest.approx(3.0, rel=0.03)


@pytest.mark.parametrize("boundary", ["circle", "left_out"])
def test_neither_the_batch_nor_its_layout_changes_a_bit(boundary):
    assert_batch_has_no_effect("modwt", ringing(6, 7, 1501), boundary=boundary)


def test_another_unit_scales_the_numbers():
    assert_unit_scales("modwt", ringing(7, 2))


def test_a_record_shorter_than_the_longest_filter_is_not_measured():
    assert obstacle("modwt", noise(8, 465)) == "5 levels of db8 need 466 samples, not 465"
    assert values("modwt", noise(8, 466), boundary="left_out")["d5"] > 0


def test_ends_that_do_not_join_leave_the_details_alone():
    record = noise(9, (1, 4000))
    ramp = np.linspace(0.0, 1e9, 4000)
    alone, tilted = values("modwt", record), values("modwt", record + ramp)
    for level in ("d1", "d2", "d3"):
        np.testing.assert_allclose(tilted[level], alone[level], rtol=1e-6)
    assert values("modwt", record + ramp, boundary="circle")["d1"] > 10.0 * alone["d1"]
