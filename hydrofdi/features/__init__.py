"""What is measured from a record."""

from hydrofdi.features.change import percentage_change
from hydrofdi.features.wavelet import coefficient_rms, detail_rms, level_bands

__all__ = ["coefficient_rms", "detail_rms", "level_bands", "percentage_change"]
