"""Generous ranges of usual sizes, of configurations and of measured channels alike."""

SUPPLY_PRESSURE = ("0.1 MPa", "150 MPa")
RETURN_PRESSURE = ("1 kPa", "20 MPa")
POSITION = ("1 µm", "10 m")
SPOOL_POSITION = ("1 µm", "50 mm")
VOLTAGE = ("10 mV", "1 kV")
