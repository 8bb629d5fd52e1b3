"""The parts of a file that become records, and pressures as shares of a reference."""
