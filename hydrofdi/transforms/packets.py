"""Wavelet packets: a decimated transform that splits details as well as approximations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def packet_coefficients(
    signal: NDArray[np.float64], wavelet: str, level: int, extension: str
) -> NDArray[np.float64]:
    """Wavelet-packet coefficients of all nodes of a level, in frequency order.

    Parameters
    ----------
    signal : ndarray, shape (..., n_time)
    wavelet, extension : str
        Names in PyWavelets.
    level : int

    Returns
    -------
    ndarray, shape (..., 2^level, n_coefficient)
        In the unit of the signal; node k nominally covers k to k + 1 times f_s/2^(level+1).
    """
    from pywt import dwt

    nodes = signal[..., None, :]
    for _ in range(level):
        children = np.stack(dwt(nodes, wavelet, mode=extension, axis=-1), axis=-2)
        # Decimation mirrors the spectrum of every high-pass branch.
        children[..., 1::2, :, :] = children[..., 1::2, ::-1, :]
        nodes = children.reshape(*signal.shape[:-1], -1, children.shape[-1])
    return nodes
