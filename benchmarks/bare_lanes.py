"""Lane kernel without options: only the equations of the paper.

The extra time of the real kernel with all options off is the cost of unused options.
"""

from __future__ import annotations

from collections import namedtuple

from hydrofdi.compilation.object_code import kernel
from hydrofdi.physics.cylinder import chamber_pressure_rates, piston_acceleration
from hydrofdi.physics.equation import equation
from hydrofdi.physics.friction import threshold_friction
from hydrofdi.physics.leakage import external_leakage_flow, internal_leakage_flow
from hydrofdi.physics.valve import chamber_1_orifice_drop, chamber_2_orifice_drop, control_flow
from hydrofdi.simulation.kernels.kernel import take_spools
from hydrofdi.simulation.kernels.lanes import HALF_WIDTH

Friction = namedtuple("Friction", "coulomb breakaway viscous transition velocity_threshold")


@equation
def rates(y, spool, h, k):
    """Rates of x_p, v_p, P_1, P_2 of lane `k` of a half."""
    x, v, p1, p2 = y
    dry = Friction(h.coulomb[k], h.breakaway[k], h.viscous[k], h.transition[k], h.velocity_threshold[k])
    friction, _ = threshold_friction(v, 0.0, dry)
    drop_1 = chamber_1_orifice_drop(spool, p1, h.rated_supply[k], h.ret[k])
    drop_2 = chamber_2_orifice_drop(spool, p2, h.rated_supply[k], h.ret[k])
    q_1 = control_flow(spool, drop_1, h.flow_gain[k], h.area_gradient[k])
    q_2 = control_flow(spool, drop_2, h.flow_gain[k], h.area_gradient[k])
    leak, swept = internal_leakage_flow(p1 - p2, h.internal_leakage[k]), h.area[k] * v
    net_1 = q_1 - leak - external_leakage_flow(p1, h.external_leakage_1[k]) - swept
    net_2 = leak - q_2 - external_leakage_flow(p2, h.external_leakage_2[k]) + swept
    volume, area = h.volume[k], h.area[k]
    rate_1, rate_2 = chamber_pressure_rates(x, net_1, net_2, h.bulk_modulus[k], volume, volume, area, area)
    return v, piston_acceleration(x, area * (p1 - p2), friction, h.mass[k], h.stiffness[k]), rate_1, rate_2


@equation
def moved(y, time, r):
    return y[0] + time * r[0], y[1] + time * r[1], y[2] + time * r[2], y[3] + time * r[3]


@equation
def weighted(a, b, c, d):
    return (
        a[0] + 2.0 * (b[0] + c[0]) + d[0],
        a[1] + 2.0 * (b[1] + c[1]) + d[1],
        a[2] + 2.0 * (b[2] + c[2]) + d[2],
        a[3] + 2.0 * (b[3] + c[3]) + d[3],
    )


@kernel
def advance(lanes, spool, drive_of_lane, step, steps_per_sample, samples):
    """Advance all lanes by the steps of `spool` (n_step, 4, n_drive)."""
    first, share_drive = drive_of_lane[0], True
    for k in range(1, 2 * HALF_WIDTH):
        share_drive &= drive_of_lane[k] == first
    left, right = lanes[0].left, lanes[0].right
    for i in range(spool.shape[0]):
        if i % steps_per_sample == 0:
            sample = samples[i // steps_per_sample]
            for k in range(HALF_WIDTH):
                sample[0, k], sample[0, HALF_WIDTH + k] = left.position[k], right.position[k]
                sample[1, k], sample[1, HALF_WIDTH + k] = left.velocity[k], right.velocity[k]
                sample[2, k], sample[2, HALF_WIDTH + k] = left.pressure_1[k], right.pressure_1[k]
                sample[3, k], sample[3, HALF_WIDTH + k] = left.pressure_2[k], right.pressure_2[k]
        stages = spool[i]
        if share_drive:
            stage_1, stage_2 = stages[0, first], stages[1, first]
            stage_3, stage_4 = stages[2, first], stages[3, first]
            for k in range(HALF_WIDTH):
                left.spool_1[k] = right.spool_1[k] = stage_1
                left.spool_2[k] = right.spool_2[k] = stage_2
                left.spool_3[k] = right.spool_3[k] = stage_3
                left.spool_4[k] = right.spool_4[k] = stage_4
        else:
            take_spools(left, stages, drive_of_lane, 0)
            take_spools(right, stages, drive_of_lane, HALF_WIDTH)
        for k in range(HALF_WIDTH):
            y = (left.position[k], left.velocity[k], left.pressure_1[k], left.pressure_2[k])
            z = (right.position[k], right.velocity[k], right.pressure_1[k], right.pressure_2[k])
            y1, z1 = rates(y, left.spool_1[k], left, k), rates(z, right.spool_1[k], right, k)
            y2 = rates(moved(y, 0.5 * step, y1), left.spool_2[k], left, k)
            z2 = rates(moved(z, 0.5 * step, z1), right.spool_2[k], right, k)
            y3 = rates(moved(y, 0.5 * step, y2), left.spool_3[k], left, k)
            z3 = rates(moved(z, 0.5 * step, z2), right.spool_3[k], right, k)
            y4 = rates(moved(y, step, y3), left.spool_4[k], left, k)
            z4 = rates(moved(z, step, z3), right.spool_4[k], right, k)
            y = moved(y, step / 6.0, weighted(y1, y2, y3, y4))
            z = moved(z, step / 6.0, weighted(z1, z2, z3, z4))
            left.position[k], left.velocity[k], left.pressure_1[k], left.pressure_2[k] = y
            right.position[k], right.velocity[k], right.pressure_1[k], right.pressure_2[k] = z
