"""Wavelet indicators: the numbers are those of PyWavelets."""

import numpy as np
import pytest
import pywt

from indicators.signals import P1, P2, batch, measured, noise, ringing, values

N = 3000


def test_the_numbers_are_those_of_pywavelets():
    first, second = noise(1, N), noise(2, N, mean=5e6)
    found, _ = measured(batch({P1: first, P2: second}), "a4")
    for name, record in (("chamber_1", first), ("chamber_2", second)):
        approximation = pywt.wavedec(record, "db8", level=4)[0]
        np.testing.assert_allclose(found[name], np.sqrt(np.mean(approximation**2)), rtol=1e-12)
    approximation, *details = pywt.wavedec(first, "db8", level=5)
    found = values("dwt", first)
    for level, coefficients in zip(range(5, 0, -1), details, strict=True):
        np.testing.assert_allclose(found[f"d{level}"], np.sqrt(np.mean(coefficients**2)), rtol=1e-12)
    np.testing.assert_allclose(found["a5"], np.sqrt(np.mean(approximation**2)), rtol=1e-12)


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


def test_ends_that_do_not_join_leave_the_details_alone():
    record = noise(9, (1, 4000))
    ramp = np.linspace(0.0, 1e9, 4000)
    alone, tilted = values("modwt", record), values("modwt", record + ramp)
    for level in ("d1", "d2", "d3"):
        np.testing.assert_allclose(tilted[level], alone[level], rtol=1e-6)
    assert values("modwt", record + ramp, boundary="circle")["d1"] > 10.0 * alone["d1"]


@pytest.mark.parametrize(("wavelet", "level", "extension"), [("db8", 4, "symmetric"), ("sym4", 3, "smooth")])
def test_nodes_are_those_of_pywavelets_in_the_order_of_frequency(wavelet, level, extension):
    record = ringing(1, 1, 1777)
    found = values("wavelet_packet", record, wavelet=wavelet, level=level, extension=extension)
    packet = pywt.WaveletPacket(record[0], wavelet, mode=extension, maxlevel=level)
    nodes = packet.get_level(level, order="freq")
    assert len(found) == len(nodes)
    for number, node in enumerate(nodes):
        np.testing.assert_allclose(found[f"n{number}"], np.sqrt(np.mean(node.data**2)), rtol=1e-12)


def test_nodes_share_the_energy_of_the_record():
    record = ringing(2, 1, 2048)
    found = values("wavelet_packet", record, level=5, extension="periodization")
    energy = sum(rms**2 for rms in found.values()) / 32
    np.testing.assert_allclose(energy, np.mean(record**2), rtol=1e-10)
