"""Indicators of spectra, envelopes, modes and wavelets, against known signals and other libraries."""

import numpy as np
import pytest
import pywt
from scipy.fft import dct
from scipy.signal import ShortTimeFFT, get_window, hilbert, welch

from hydrofdi.errors import ConfigError
from hydrofdi.indicators import make_indicators
from hydrofdi.indicators.catalogue.modes import empirical_modes, variational_modes
from hydrofdi.indicators.catalogue.spectra import short_time_spectra
from hydrofdi.indicators.catalogue.transients import analytic_signal
from indicators.signals import P1, P2, SAMPLING_FREQUENCY, batch, measured, noise, records, ringing, values


def rms(samples):
    return np.sqrt(np.mean(np.square(samples)))


def tone(frequency, n_time=4000):
    return 8e6 + 2e5 * np.sin(2 * np.pi * frequency * np.arange(n_time) / SAMPLING_FREQUENCY + 0.3)


@pytest.mark.parametrize("segment", [1.0, 0.514])
def test_bands_without_a_gap_share_the_power_of_the_spectrum(segment):
    record = ringing(1, 1)
    frequency, density = welch(record[0], SAMPLING_FREQUENCY, "hann", round(segment * SAMPLING_FREQUENCY))
    bands = [[0, 3.3], [3.3, "41 Hz"], ["41 Hz", 41.2], [41.2, 250]]
    for options in ({}, {"bands": bands}):
        found = values("band_power", record, segment=segment, **options)
        np.testing.assert_allclose(
            sum(each**2 for each in found.values()), sum(density) * frequency[1], rtol=1e-12
        )


def test_a_band_that_ends_between_two_lines_has_its_share_of_them_and_one_that_falls_is_a_mistake():
    record = ringing(2, 1)
    _, density = welch(record[0], SAMPLING_FREQUENCY, "hann", 500)
    found = values("band_power", record, bands=[[40.25, 42.5]])
    np.testing.assert_allclose(found["b1"] ** 2, 0.25 * density[40] + density[41] + density[42], rtol=1e-12)
    with pytest.raises(ConfigError, match="bands"):
        make_indicators({"band_power": {"bands": [[90, 40]]}})
    found = values("band_power", tone(90.0, 5000))
    assert found.pop("b2") == pytest.approx(2e5 / np.sqrt(2), rel=1e-9)
    assert all(other < 1.0 for other in found.values())


@pytest.mark.parametrize(("n_segment", "hop"), [(125, 31), (128, 64)])
def test_spectra_are_those_of_scipy(n_segment, hop):
    record, window = noise(1, 2000), get_window("hann", n_segment)
    library = ShortTimeFFT(window, hop, SAMPLING_FREQUENCY, scale_to="magnitude")
    ours = short_time_spectra(record, n_segment, hop)
    theirs = library.stft_detrend(record, "constant", 0, len(ours), k_offset=library.m_num_mid)
    np.testing.assert_allclose(np.abs(ours), 2 * np.abs(theirs.T), rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize("frequency", [40.0, 68.7, 111.3])
def test_a_tone_is_found_between_the_lines_of_the_spectrum_and_in_the_band_alone(frequency):
    found = values("stft", tone(frequency))
    assert found["frequency"] == pytest.approx(frequency, abs=0.02)
    assert found["amplitude"] == pytest.approx(2e5, rel=0.005)
    assert found["frequency_spread"] < 0.1
    assert found["amplitude_spread"] < 2e3
    both = tone(100.0) + 0.1 * tone(60.0)
    assert values("stft", both, band=["40 Hz", "80 Hz"])["frequency"] == pytest.approx(60.0, abs=0.5)


def test_a_frequency_that_rises_has_its_mean_and_its_spread():
    time = np.arange(8000) / SAMPLING_FREQUENCY
    found = values("stft", 1e5 * np.sin(2 * np.pi * (50.0 + 1.25 * time) * time))
    assert found["frequency"] == pytest.approx(70.0, abs=0.3)
    assert found["frequency_spread"] == pytest.approx(40.0 / np.sqrt(12), rel=0.05)


@pytest.mark.parametrize("n_time", [2000, 2001])
def test_the_analytic_signal_of_what_lies_in_the_band_is_that_of_scipy(n_time):
    time = np.arange(n_time) / n_time
    signal = np.cos(2 * np.pi * 300 * time) * (1.0 + 0.5 * np.cos(2 * np.pi * 4 * time))
    ours = analytic_signal(8e6 + signal, n_time, (100.0, 500.0))
    np.testing.assert_allclose(ours, hilbert(signal), atol=1e-8)


@pytest.mark.parametrize("rate", [4.0, 20.0])
def test_the_decay_after_steps_is_found_and_a_record_that_stands_still_has_none(rate):
    """A pressure that steps every second and rings at 70 Hz."""
    time = np.arange(5000) / SAMPLING_FREQUENCY
    rings = 1.0 - np.exp(-rate * (time % 1.0)) * np.cos(2 * np.pi * 70.0 * (time % 1.0))
    pressure = 8e6 + 1e6 * np.where(time % 2.0 < 1.0, 1.0, -1.0) * rings
    found = values("envelope", records(pressure, drive_period=2.0))
    assert found["decay_rate"] == pytest.approx(rate, rel=0.03)
    assert found["decay_rate_spread"] < 0.05 * rate
    assert found["steps"] == 9
    still = values("envelope", records(np.full(2000, 8e6), drive_period=2.0))
    assert still["amplitude"] == pytest.approx(0.0, abs=1e-3)
    assert still["steps"] == 0
    assert np.isnan(still["decay_rate"])


def test_a_tone_in_the_band_has_its_amplitude_and_white_noise_the_power_of_the_band():
    assert values("envelope", tone(70.0, 5000))["amplitude"] == pytest.approx(2e5, rel=1e-9)
    found = values("envelope", noise(3, (8, 20_000), size=4.0, mean=0.0), band=[40, 120])
    passed = 80.0 * (0.25 + 0.75 * 3 / 8)  # the edges pass the mean of sin^4
    assert rms(found["amplitude"]) == pytest.approx(4.0 * np.sqrt(2.0 * passed / 250.0), rel=0.03)


def test_tones_are_variational_modes_with_their_frequency_and_size():
    time, parts = np.arange(3001) / SAMPLING_FREQUENCY, {10.0: 8e5, 70.0: 2e5, 150.0: 4e5}
    tones = (size * np.cos(2 * np.pi * frequency * time) for frequency, size in parts.items())
    found = values("vmd", 8e6 + sum(tones), modes=3)
    for mode, (frequency, size) in enumerate(parts.items(), 1):
        assert found[f"frequency{mode}"] == pytest.approx(frequency, abs=0.5)
        assert found[f"rms{mode}"] == pytest.approx(size / np.sqrt(2), rel=0.02)
    assert found["iterations"] < 1000
    record = ringing(1, 1)
    found = values("vmd", record, modes=1, bandwidth_weight=1e-12)
    np.testing.assert_allclose(found["rms1"], record.std(), rtol=1e-9)


def test_modes_are_where_no_change_of_them_lowers_the_cost():
    record, weight, frequency = ringing(2, 1, 600)[0], 2000.0, np.arange(600) / 1200.0
    spectrum = dct(record - record.mean(), norm="ortho")
    found, centres, _ = variational_modes(record, 2, weight, 1e-16, 10_000)
    gains = 1.0 / (weight * np.square(frequency - centres[:, None]))
    others = spectrum / (1.0 + gains.sum(axis=0))  # what the modes leave of the spectrum at the optimum
    modes = np.where(np.isfinite(gains), gains, 0.0) * others
    np.testing.assert_allclose(np.sqrt(np.mean(modes**2, axis=1)), found, rtol=1e-3)


def test_two_tones_are_two_empirical_modes_and_those_of_a_mirror_image_are_the_same():
    time = np.arange(5000) / SAMPLING_FREQUENCY
    fast, slow = 3e5 * np.sin(2 * np.pi * 60.0 * time), 5e5 * np.sin(2 * np.pi * 7.0 * time)
    found = values("emd", 8e6 + fast + slow)
    assert found["imf1"] == pytest.approx(3e5, rel=0.01)
    assert found["imf2"] == pytest.approx(5e5, rel=0.02)
    assert found["imf3"] < 5e4  # from the ends of the record
    record = ringing(2, 1)
    one, other = values("emd", record), values("emd", record[:, ::-1].copy())
    for key in one:
        assert one[key] == pytest.approx(other[key][0], rel=1e-6)


def test_empirical_modes_oscillate_about_zero_and_what_they_leave_is_slower():
    record = ringing(1, 1)[0]
    modes = empirical_modes(record, 4, 10)
    crossings = [np.count_nonzero(np.diff(np.sign(mode))) for mode in modes]
    assert crossings == sorted(crossings, reverse=True)
    for mode in modes[:3]:
        assert abs(mode.mean()) < 0.1 * mode.std()
    rest = record - modes.sum(axis=0)
    assert np.count_nonzero(np.diff(np.sign(np.diff(rest)))) < crossings[3]
    for record in (np.full(500, 8e6), np.linspace(1e6, 9e6, 500), np.r_[np.ones(250), np.zeros(250)]):
        assert all(amplitude == 0.0 for amplitude in values("emd", record).values())
    found = values("emd", 8e6 + 1e6 * np.sin(np.linspace(0.0, 2.0 * np.pi, 400)), modes=10, siftings=100)
    assert all(np.isfinite(amplitude) for amplitude in found.values())


def test_details_and_approximations_of_both_chambers_are_those_of_pywavelets():
    first, second = noise(1, 3000), noise(2, 3000, mean=5e6)
    found, _ = measured(batch({P1: first, P2: second}), "a4")
    for name, record in (("chamber_1", first), ("chamber_2", second)):
        np.testing.assert_allclose(found[name], rms(pywt.wavedec(record, "db8", level=4)[0]), rtol=1e-12)


@pytest.mark.parametrize("wavelet", ["db8", "haar", "sym5"])
def test_undecimated_coefficients_are_those_of_pywavelets(wavelet):
    record = ringing(1, 1, 2048)
    found = values("modwt", record, wavelet=wavelet, levels=4, boundary="circle")
    for level, pair in zip(range(4, 0, -1), pywt.swt(record[0], wavelet, 4), strict=True):
        np.testing.assert_allclose(
            [found[f"a{level}"][0], found[f"d{level}"][0]], [*map(rms, pair)], rtol=1e-9
        )


def test_without_the_boundary_only_coefficients_inside_the_record_count():
    record = ringing(2, 1, 1024)
    found = values("modwt", record, levels=3, boundary="left_out")
    approximation = record[0]
    for level in range(1, 4):
        low, high = np.zeros((2, 15 * 2 ** (level - 1) + 1))
        low[:: 2 ** (level - 1)], high[:: 2 ** (level - 1)] = pywt.Wavelet("db8").filter_bank[:2]
        detail, approximation = (np.convolve(approximation, taps, "valid") for taps in (high, low))
        np.testing.assert_allclose(found[f"d{level}"], rms(detail), rtol=1e-9)
        np.testing.assert_allclose(found[f"a{level}"], rms(approximation), rtol=1e-9)


@pytest.mark.parametrize(("wavelet", "level", "extension"), [("db8", 4, "symmetric"), ("sym4", 3, "smooth")])
def test_packets_are_those_of_pywavelets_in_the_order_of_frequency(wavelet, level, extension):
    record = ringing(1, 1, 1777)
    found = values("wavelet_packet", record, wavelet=wavelet, level=level, extension=extension)
    packet = pywt.WaveletPacket(record[0], wavelet, mode=extension, maxlevel=level)
    expected = [rms(node.data) for node in packet.get_level(level, order="freq")]
    np.testing.assert_allclose([found[f"n{number}"][0] for number in range(len(found))], expected, rtol=1e-12)
