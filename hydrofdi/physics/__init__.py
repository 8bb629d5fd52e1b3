"""The equations: small pure functions, each named by the quantity that it returns.

They take floats or NumPy arrays, and the simulation kernel compiles the very same functions. Equation
numbers are those of Maddahi et al., CDSR 2015, paper 181.
"""

PHYSICS_VERSION = 4
"""Version of everything that determines the results of a run (equations, kernel, features, defaults).

It is part of every run's identity: raise it when results change, and stored runs are computed again.
"""
