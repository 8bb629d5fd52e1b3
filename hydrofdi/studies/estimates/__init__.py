"""How far estimates of known quantities are from the truth, and whether their intervals cover it."""
