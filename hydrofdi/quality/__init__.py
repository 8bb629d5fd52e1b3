"""How far a simulated run can be believed: its plant, its balances, how its record settles."""
