"""Internal leakage and bulk modulus from the volume balance of the chambers."""

from __future__ import annotations

from hydrofdi.indicators.balancing import BalanceIndicator, BalanceOptions


class FlowBalance(BalanceIndicator[BalanceOptions]):
    """Internal leakage, bulk modulus and valve parameters from the volume balance of the chambers."""

    name = "flow_balance"
    version = 7
    source = (
        "weak form: Shinbrot, NACA TN 3288 (1954); balance: equations (5) to (8) and (11) of the paper;"
        " deviations: Tarantola, Inverse Problem Theory (2005), section 3.2"
    )
    equation = (
        "∫φ(q_1 − A x_p') = K_i ∫φ sgn(ΔP) √abs(ΔP) + (1/β) ∫φ (V + A x_p) P_1', φ = sin²; chamber 2"
        " alike; q_1 = K_v w g_e (x_v − x_0 ∓ lap_e) √drop + c (P_s + P_r − 2 P_1) for the open edge e,"
        " c ≥ 0; 1/β + air (P_a/P)^(3/4)·3/(4P) for free air; P_s falls with the flow drawn; all but K_i are"
        " constrained to nominal values by their prior deviations. Errors have the standard deviation e, or"
        " e misfit if that is larger. Stated deviations of flows count the excess 50 times, allow three times"
        " the prior deviations, 5 % of the flow of c in K_i, and 30 % of mean_leakage for its law and place."
        " mean_leakage and cross_port_leakage follow from a second solution whose c may be that of a leak."
        " For the mean_leakage of a record each tenth of the way has its own K_i, which differs by three"
        " times the common one, and covariances of residuals of windows apart count like an excess"
    )
    caution = (
        "K_i (leakage) finds a hole or a scored bore whatever the valve leaks. mean_leakage and"
        " cross_port_leakage are right for any law, but contain the clearance of the valve: a gap is found"
        " beyond its null leakage alone, and cannot be told from a valve that leaks more. Pressure noise"
        " biases β upwards."
    )
    Options = BalanceOptions
