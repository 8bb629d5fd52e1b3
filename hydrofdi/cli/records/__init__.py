"""Commands on records, simulated or measured, and on what is measured of them."""
