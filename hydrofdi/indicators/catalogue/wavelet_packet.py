"""RMS of the nodes of a wavelet packet transform."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import ChannelOptions, SingleChannelIndicator
from hydrofdi.records import Array, RecordBatch
from hydrofdi.transforms.wavelet import Extension, WaveletName, root_mean_square, shortage


def packet_coefficients(
    signal: NDArray[np.float64], wavelet: str, level: int, extension: str
) -> NDArray[np.float64]:
    """Wavelet-packet coefficients of all nodes of a level, in frequency order.

    Shape (..., 2^level, n_coefficient); node k nominally covers k to k + 1 times f_s/2^(level+1).
    """
    from pywt import dwt

    nodes = signal[..., None, :]
    for _ in range(level):
        children = np.stack(dwt(nodes, wavelet, mode=extension, axis=-1), axis=-2)
        # Decimation mirrors the spectrum of every high-pass branch.
        children[..., 1::2, :, :] = children[..., 1::2, ::-1, :]
        nodes = children.reshape(*signal.shape[:-1], -1, children.shape[-1])
    return nodes


class WaveletPacketOptions(ChannelOptions):
    """Options of `WaveletPacket`."""

    wavelet: WaveletName = "db8"
    """Name in PyWavelets."""

    level: Annotated[int, Field(strict=True, ge=1, le=10)] = 4
    """Level whose 2^level nodes are measured; up to level 5 the cost is small."""

    extension: Extension = "symmetric"
    """Extension of the record at its ends."""


class WaveletPacket(SingleChannelIndicator[WaveletPacketOptions]):
    """RMS of the coefficients of each node of a wavelet packet: bands of equal width."""

    name = "wavelet_packet"
    version = 1
    source = "Coifman and Wickerhauser, IEEE Trans. Inf. Theory 38(2) (1992) 713"
    equation = "n_k = sqrt(mean over i of w_k[i]²); node k covers k to k + 1 times f_s/2^(level+1)"
    Options = WaveletPacketOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """n0, n1, …, each with its band."""
        parts = 2 ** (self.options.level + 1)
        return tuple(
            Output(
                f"n{node}", self.unit, f"RMS of the packet from {node}/{parts} to {node + 1}/{parts} of f_s"
            )
            for node in range(parts // 2)
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record is too short for the level."""
        return shortage(records.n_time, self.options.wavelet, self.options.level)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """RMS in the unit of the channel, each (n_record,)."""
        options = self.options
        nodes = packet_coefficients(self.signal(records), options.wavelet, options.level, options.extension)
        rms = root_mean_square(nodes)
        return {output.name: rms[:, node] for node, output in enumerate(self.outputs)}
