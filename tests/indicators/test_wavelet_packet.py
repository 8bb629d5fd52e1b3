import numpy as np
import pytest
import pywt

from indicators.laws import (
    SAMPLING_FREQUENCY,
    noise,
    ringing,
    values,
)


@pytest.mark.parametrize(("wavelet", "level", "extension"), [("db8", 4, "symmetric"), ("sym4", 3, "smooth")])
def test_nodes_are_those_of_pywavelets_in_the_order_of_frequency(wavelet, level, extension):
    record = ringing(1, 1, 1777)
    found = values("wavelet_packet", record, wavelet=wavelet, level=level, extension=extension)
    packet = pywt.WaveletPacket(record[0], wavelet, mode=extension, maxlevel=level)
    nodes = packet.get_level(level, order="freq")
    assert len(found) == len(nodes)
    for number, node in enumerate(nodes):
        np.testing.assert_allclose(found[f"n{number}"], np.sqrt(np.mean(node.data**2)), rtol=1e-12)


@pytest.mark.parametrize("node", range(8))
def test_a_tone_in_the_middle_of_a_band_is_in_its_node(node):
    time = np.arange(4000) / SAMPLING_FREQUENCY
    tone = np.sin(2 * np.pi * (node + 0.5) * SAMPLING_FREQUENCY / 16 * time)
    found = values("wavelet_packet", tone, level=3)
    assert max(found, key=lambda name: found[name][0]) == f"n{node}"


def test_nodes_share_the_energy_of_the_record():
    record = ringing(2, 1, 2048)
    found = values("wavelet_packet", record, level=5, extension="periodization")
    energy = sum(rms**2 for rms in found.values()) / 32
    np.testing.assert_allclose(energy, np.mean(record**2), rtol=1e-10)


def test_white_noise_has_its_standard_deviation_in_each_node():
    found = values("wavelet_packet", noise(3, (16, 8192), size=3.0, mean=0.0), extension="periodization")
    for rms in found.values():
        assert np.sqrt(np.mean(rms**2)) == pytest.approx(3.0, rel=0.05)
