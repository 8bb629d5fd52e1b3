import numpy as np
import pytest

from hydrofdi.transforms.free_motion import common_motion, fit_free_motion

TIME = np.arange(120) / 120.0


def motion(frequency, damping_ratio, seed, n_piece=6):
    """Pieces of the free motion from random states; frequency in cycles per piece."""
    natural = 2.0 * np.pi * frequency
    root = natural * np.sqrt(complex(damping_ratio**2 - 1.0))
    draw, decay = np.random.default_rng(seed), np.exp(-damping_ratio * natural * TIME)
    shapes = np.stack((np.cosh(root * TIME).real, (natural * np.sinh(root * TIME) / root).real))
    return decay * (draw.normal(size=(n_piece, 2)) @ shapes)


@pytest.mark.parametrize(("frequency", "damping_ratio"), [(3.0, 0.05), (12.0, 0.3), (25.0, 0.01), (1.0, 2.0)])
def test_the_pencil_finds_the_common_motion_of_pieces_without_noise(frequency, damping_ratio):
    pieces = np.concatenate((motion(frequency, damping_ratio, 1), motion(2.0 * frequency, 0.2, 2)))
    a, b = common_motion(pieces, np.repeat([0, 3], 6))
    np.testing.assert_allclose(np.sqrt(b[:6]) / (2 * np.pi), frequency, rtol=1e-4)
    np.testing.assert_allclose(a[:6] / (2 * np.sqrt(b[:6])), damping_ratio, rtol=1e-4)
    np.testing.assert_allclose(np.sqrt(b[6:]) / (2 * np.pi), 2.0 * frequency, rtol=1e-4)


@pytest.mark.parametrize(("frequency", "damping_ratio"), [(12.0, 0.05), (6.0, 0.3), (4.0, 0.5), (1.5, 1.6)])
def test_least_squares_find_it_beside_a_polynomial(frequency, damping_ratio):
    pieces = 5.0 + 3.0 * TIME - 2.0 * TIME**2 + motion(frequency, damping_ratio, 3)
    found = fit_free_motion(pieces, np.zeros(6, dtype=np.intp), 1200.0, 2)
    np.testing.assert_allclose(found.frequency, 10.0 * frequency, rtol=1e-6)
    np.testing.assert_allclose(found.damping_ratio, damping_ratio, rtol=1e-6)
    np.testing.assert_allclose(found.explained, 1.0, rtol=1e-9)


def test_what_the_motion_explains_of_white_noise_is_little():
    noise = np.random.default_rng(4).normal(size=(500, 120))
    with np.errstate(all="ignore"):
        explained = fit_free_motion(noise, np.arange(500) // 10, 1200.0, 2).explained
    assert np.nanquantile(explained, 0.99) < 0.2
