"""hydrofdi: wavelet-based diagnosis of internal leakage in hydraulic actuators."""

__version__ = "0.1.0"
