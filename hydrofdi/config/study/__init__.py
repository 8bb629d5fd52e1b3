"""A study of detection: what varies without a fault, the faults, and how they are told apart."""
