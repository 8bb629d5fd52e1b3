"""Internal leakage and bulk modulus from the volume balance of the chambers."""

from __future__ import annotations

from hydrofdi.indicators.balancing import BalanceIndicator, BalanceOptions


class FlowBalance(BalanceIndicator[BalanceOptions]):
    """Internal leakage, bulk modulus and valve parameters from the volume balance of the chambers."""

    name = "flow_balance"
    version = 5
    source = (
        "weak form: Shinbrot, NACA TN 3288 (1954); balance: equations (5) to (8) and (11) of the paper;"
        " deviations: Tarantola, Inverse Problem Theory (2005), section 3.2"
    )
    equation = (
        "∫φ(q_1 − A x_p') = K_i ∫φ sgn(ΔP) √abs(ΔP) + (1/β) ∫φ (V + A x_p) P_1', φ = sin²; chamber 2"
        " alike; q_1 = K_v w g_e (x_v − x_0 ∓ lap_e) √drop + c (P_s + P_r − 2 P_1) for the open edge e,"
        " c ≥ 0; 1/β + air (P_a/P)^(3/4)·3/(4P) for free air; P_s falls with the flow drawn; all but K_i are"
        " constrained to nominal values by their prior deviations. Errors have the variance s² = e² (1 + 25"
        " (misfit² − 1)) if the misfit exceeds 1"
    )
    caution = (
        "A leak proportional to ΔP cannot be distinguished from valve clearance: cross_port_leakage and"
        " mean_leakage contain both; for an orifice, K_i is more sensitive. The deviation of mean_leakage"
        " allows for any law, that of K_i for a valve clearance of ten times its prior deviation. Pressure"
        " noise biases β upwards."
    )
    Options = BalanceOptions
