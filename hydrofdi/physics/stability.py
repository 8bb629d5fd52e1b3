"""Stability limit of the classic Runge-Kutta method."""

from __future__ import annotations

import cmath
from functools import lru_cache


def amplification(product: complex) -> complex:
    """Factor by which one step of classic Runge-Kutta amplifies a mode.

    Parameters
    ----------
    product : complex
        hλ, step times eigenvalue [-].

    Returns
    -------
    complex
        R(hλ) = 1 + hλ + (hλ)²/2 + (hλ)³/6 + (hλ)⁴/24.
    """
    return 1.0 + product * (1.0 + product / 2.0 * (1.0 + product / 3.0 * (1.0 + product / 4.0)))


def largest_stable_step(eigenvalue: complex) -> float:
    """Longest step at which classic Runge-Kutta does not amplify a mode.

    Parameters
    ----------
    eigenvalue : complex
        λ [1/s], with non-positive real part.

    Returns
    -------
    float
        h [s] with abs(R(hλ)) = 1; 2.785/abs(λ) on the real and 2.828/abs(λ) on the imaginary axis.
    """
    return _largest_stable_product(eigenvalue / abs(eigenvalue)) / abs(eigenvalue)


@lru_cache(maxsize=65536)
def _largest_stable_product(direction: complex) -> float:
    """Largest abs(hλ) that does not amplify a mode with this direction in the complex plane."""
    stable, unstable = 0.0, 0.05
    while abs(amplification(unstable * direction)) <= 1.0 + 1e-12:
        stable, unstable = unstable, unstable + 0.05
    for _ in range(50):
        middle = 0.5 * (stable + unstable)
        if abs(amplification(middle * direction)) <= 1.0 + 1e-12:
            stable = middle
        else:
            unstable = middle
    return stable


def second_order_eigenvalues(frequency: float, damping_ratio: float) -> tuple[complex, complex]:
    """Eigenvalues of a second-order lag: λ = −ζω ± ω√(ζ² − 1) [1/s], ω in rad/s."""
    root = cmath.sqrt(damping_ratio**2 - 1.0)
    return frequency * (-damping_ratio - root), frequency * (-damping_ratio + root)
