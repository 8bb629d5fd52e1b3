"""Internal leakage and bulk modulus from the volume balance of the chambers."""

from __future__ import annotations

from hydrofdi.indicators.balancing import BalanceIndicator, BalanceOptions


class FlowBalance(BalanceIndicator[BalanceOptions]):
    """Internal leakage, bulk modulus and valve parameters from the volume balance of the chambers."""

    name = "flow_balance"
    version = 3
    source = (
        "weak form: Shinbrot, NACA TN 3288 (1954); balance: equations (5) to (8) and (11) of the paper;"
        " deviations: Tarantola, Inverse Problem Theory (2005), section 3.2"
    )
    equation = (
        "∫φ(q_1 − A x_p') = K_i ∫φ sgn(ΔP) √abs(ΔP) + (1/β) ∫φ (V + A x_p) P_1', φ = sin²; chamber 2"
        " alike; q_1 = K_v w (x_v − x_0 ∓ lap) √drop + c (P_s + P_r − 2 P_1); all but K_i are constrained"
        " to nominal values by their prior deviations"
    )
    caution = (
        "A leak proportional to ΔP cannot be distinguished from valve clearance: cross_port_leakage"
        " contains both and covers any leakage law; for an orifice, K_i is more sensitive. Pressure noise"
        " biases β upwards."
    )
    Options = BalanceOptions
