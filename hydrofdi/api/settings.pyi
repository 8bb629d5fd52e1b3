# written by docs/generate_configuration.py

from typing import Any, TypedDict

class Settings(TypedDict, total=False):
    mass: float | str  # actuator.mass [kg]
    piston_area: float | str  # actuator.piston_area [m²]
    piston_area_2: float | str  # actuator.piston_area_2 [m²]
    chamber_volume: float | str  # actuator.chamber_volume [m³]
    chamber_volume_2: float | str  # actuator.chamber_volume_2 [m³]
    stroke: float | str  # actuator.stroke [m]
    inclination: float | str  # actuator.inclination [rad]
    load_stiffness: float | str  # actuator.load_stiffness [N/m]
    end_stops: Any  # actuator.end_stops
    end_stop_position: float | str  # actuator.end_stop_position [m]
    end_stop_stiffness: float | str  # actuator.end_stop_stiffness [N/m]
    hose_volume: float | str  # actuator.hose_volume [m³]
    hose_modulus: float | str  # actuator.hose_modulus [Pa]
    hose_resistance: float | str  # actuator.hose_resistance [Pa·s/m³]
    hose_inertance: float | str  # actuator.hose_inertance [kg/m^4]
    foundation_stiffness: float | str  # actuator.foundation_stiffness [N/m]
    foundation_damping: float | str  # actuator.foundation_damping [N·s/m]
    pressure: float | str  # supply.pressure [Pa]
    return_pressure: float | str  # supply.return_pressure [Pa]
    droop: Any  # supply.droop
    droop_resistance: float | str  # supply.droop_resistance [Pa·s/m³]
    droop_time_constant: float | str  # supply.droop_time_constant [s]
    ripple: float | str  # supply.ripple
    ripple_frequency: float | str  # supply.ripple_frequency [Hz]
    return_resistance: float | str  # supply.return_resistance [Pa·s/m³]
    return_time_constant: float | str  # supply.return_time_constant [s]
    bulk_modulus: float | str  # fluid.bulk_modulus [Pa]
    bulk_modulus_pressure_slope: float | str  # fluid.bulk_modulus_pressure_slope
    vapour_pressure: float | str  # fluid.vapour_pressure [Pa]
    free_air: float | str  # fluid.free_air
    polytropic_exponent: float | str  # fluid.polytropic_exponent
    atmospheric_pressure: float | str  # fluid.atmospheric_pressure [Pa]
    temperature: float | str  # fluid.temperature [K]
    temperature_rise: float | str  # fluid.temperature_rise [K]
    temperature_drift: float | str  # fluid.temperature_drift [K/s]
    bulk_modulus_slope: float | str  # fluid.bulk_modulus_slope [1/K]
    viscosity_slope: float | str  # fluid.viscosity_slope [1/K]
    flow_gain: float | str  # valve.flow_gain [m^1.5/kg^0.5]
    area_gradient: float | str  # valve.area_gradient [m]
    spool_gain: float | str  # valve.spool_gain [m/V]
    natural_frequency: float | str  # valve.natural_frequency [Hz]
    largest_opening: float | str  # valve.largest_opening [m]
    largest_speed: float | str  # valve.largest_speed [m/s]
    hysteresis: float | str  # valve.hysteresis [V]
    edge_rounding: float | str  # valve.edge_rounding [m]
    gain_slope: float | str  # valve.gain_slope [1/m]
    null_offset: float | str  # valve.null_offset [m]
    null_drift: float | str  # valve.null_drift [m/s]
    coulomb: float | str  # friction.coulomb [N]
    breakaway: float | str  # friction.breakaway [N]
    viscous: float | str  # friction.viscous [N·s/m]
    transition: float | str  # friction.transition [s/m]
    scale: float | str  # friction.scale
    velocity_threshold: float | str  # friction.velocity_threshold [m/s]
    bristle_stiffness: float | str  # friction.bristle_stiffness [N/m]
    bristle_damping: float | str  # friction.bristle_damping [N·s/m]
    pressure_slope: float | str  # friction.pressure_slope [1/Pa]
    position_share: float | str  # friction.position_share
    position_period: float | str  # friction.position_period [m]
    internal_coefficient: float | str  # leakage.internal_coefficient [m³/s/√Pa]
    internal_flow: float | str  # leakage.internal_flow [m³/s]
    external_coefficient: float | str  # leakage.external_coefficient [m³/(s·Pa)]
    external_coefficient_1: float | str  # leakage.external_coefficient_1 [m³/(s·Pa)]
    external_coefficient_2: float | str  # leakage.external_coefficient_2 [m³/(s·Pa)]
    laminar_reference: float | str  # leakage.laminar_reference [Pa]
    blending_pressure: float | str  # leakage.blending_pressure [Pa]
    drag: float | str  # leakage.drag [Pa·s/m]
    scored_centre: float | str  # leakage.scored_centre [m]
    scored_width: float | str  # leakage.scored_width [m]
    onset: Any  # leakage.onset
    onset_time: float | str  # leakage.onset_time [s]
    onset_duration: float | str  # leakage.onset_duration [s]
    shape: Any  # input.shape
    period: float | str  # input.period [s]
    file: Any  # input.file
    feedback: Any  # control.feedback
    proportional_gain: float | str  # control.proportional_gain [V/m]
    integral_gain: float | str  # control.integral_gain [V/(m·s)]
    derivative_gain: float | str  # control.derivative_gain [V·s/m]
    sample_time: float | str  # control.sample_time [s]
    voltage_limit: float | str  # control.voltage_limit [V]
    constant_force: float | str  # load.constant_force [N]
    random_force: float | str  # load.random_force [N]
    random_period: float | str  # load.random_period [s]
    random_change: float | str  # load.random_change [s]
    duration: float | str  # record.duration [s]
    step: float | str  # record.step [s]
    sampling_frequency: float | str  # record.sampling_frequency [Hz]
    pairing: Any  # measurement.pairing
    jitter: float | str  # measurement.jitter [s]
    pressures_at: Any  # measurement.pressures_at
    anti_alias: float | str  # measurement.anti_alias [Hz]
    anti_alias_order: Any  # measurement.anti_alias_order
    discard: float | str  # analysis.discard [s]
    levels: Any  # wavelet.levels
    extension: Any  # wavelet.extension
    boundary: Any  # wavelet.boundary
    phase: Any  # wavelet.phase
    fluid__law: Any  # fluid.law
    valve__lap: float | str  # valve.lap [m]
    valve__lap_leakage: float | str  # valve.lap_leakage [m³/(s·Pa)]
    supply_1_edge__lap: float | str  # supply_1_edge.lap [m]
    supply_1_edge__lap_leakage: float | str  # supply_1_edge.lap_leakage [m³/(s·Pa)]
    supply_1_edge__flow_gain_ratio: float | str  # supply_1_edge.flow_gain_ratio
    return_1_edge__lap: float | str  # return_1_edge.lap [m]
    return_1_edge__lap_leakage: float | str  # return_1_edge.lap_leakage [m³/(s·Pa)]
    return_1_edge__flow_gain_ratio: float | str  # return_1_edge.flow_gain_ratio
    supply_2_edge__lap: float | str  # supply_2_edge.lap [m]
    supply_2_edge__lap_leakage: float | str  # supply_2_edge.lap_leakage [m³/(s·Pa)]
    supply_2_edge__flow_gain_ratio: float | str  # supply_2_edge.flow_gain_ratio
    return_2_edge__lap: float | str  # return_2_edge.lap [m]
    return_2_edge__lap_leakage: float | str  # return_2_edge.lap_leakage [m³/(s·Pa)]
    return_2_edge__flow_gain_ratio: float | str  # return_2_edge.flow_gain_ratio
    friction__law: Any  # friction.law
    leakage__law: Any  # leakage.law
    input__seed: Any  # input.seed
    control__law: Any  # control.law
    control__amplitude: float | str  # control.amplitude [m]
    load__seed: Any  # load.seed
    measurement__seed: Any  # measurement.seed
    pressure_1_sensor__order: Any  # pressure_1_sensor.order
    pressure_1_sensor__bandwidth: float | str  # pressure_1_sensor.bandwidth [Hz]
    pressure_1_sensor__damping_ratio: float | str  # pressure_1_sensor.damping_ratio
    pressure_1_sensor__noise: float | str  # pressure_1_sensor.noise [Pa]
    pressure_1_sensor__noise_bandwidth: float | str  # pressure_1_sensor.noise_bandwidth [Hz]
    pressure_1_sensor__noise_density: float | str  # pressure_1_sensor.noise_density [Pa/Hz^0.5]
    pressure_1_sensor__bias: float | str  # pressure_1_sensor.bias [Pa]
    pressure_1_sensor__drift: float | str  # pressure_1_sensor.drift [Pa/s]
    pressure_1_sensor__gain_error: float | str  # pressure_1_sensor.gain_error
    pressure_1_sensor__hum: float | str  # pressure_1_sensor.hum [Pa]
    pressure_1_sensor__hum_frequency: float | str  # pressure_1_sensor.hum_frequency [Hz]
    pressure_1_sensor__delay: float | str  # pressure_1_sensor.delay [s]
    pressure_1_sensor__lowest: float | str  # pressure_1_sensor.lowest [Pa]
    pressure_1_sensor__highest: float | str  # pressure_1_sensor.highest [Pa]
    pressure_1_sensor__bits: Any  # pressure_1_sensor.bits
    pressure_2_sensor__order: Any  # pressure_2_sensor.order
    pressure_2_sensor__bandwidth: float | str  # pressure_2_sensor.bandwidth [Hz]
    pressure_2_sensor__damping_ratio: float | str  # pressure_2_sensor.damping_ratio
    pressure_2_sensor__noise: float | str  # pressure_2_sensor.noise [Pa]
    pressure_2_sensor__noise_bandwidth: float | str  # pressure_2_sensor.noise_bandwidth [Hz]
    pressure_2_sensor__noise_density: float | str  # pressure_2_sensor.noise_density [Pa/Hz^0.5]
    pressure_2_sensor__bias: float | str  # pressure_2_sensor.bias [Pa]
    pressure_2_sensor__drift: float | str  # pressure_2_sensor.drift [Pa/s]
    pressure_2_sensor__gain_error: float | str  # pressure_2_sensor.gain_error
    pressure_2_sensor__hum: float | str  # pressure_2_sensor.hum [Pa]
    pressure_2_sensor__hum_frequency: float | str  # pressure_2_sensor.hum_frequency [Hz]
    pressure_2_sensor__delay: float | str  # pressure_2_sensor.delay [s]
    pressure_2_sensor__lowest: float | str  # pressure_2_sensor.lowest [Pa]
    pressure_2_sensor__highest: float | str  # pressure_2_sensor.highest [Pa]
    pressure_2_sensor__bits: Any  # pressure_2_sensor.bits
    supply_sensor__order: Any  # supply_sensor.order
    supply_sensor__bandwidth: float | str  # supply_sensor.bandwidth [Hz]
    supply_sensor__damping_ratio: float | str  # supply_sensor.damping_ratio
    supply_sensor__noise: float | str  # supply_sensor.noise [Pa]
    supply_sensor__noise_bandwidth: float | str  # supply_sensor.noise_bandwidth [Hz]
    supply_sensor__noise_density: float | str  # supply_sensor.noise_density [Pa/Hz^0.5]
    supply_sensor__bias: float | str  # supply_sensor.bias [Pa]
    supply_sensor__drift: float | str  # supply_sensor.drift [Pa/s]
    supply_sensor__gain_error: float | str  # supply_sensor.gain_error
    supply_sensor__hum: float | str  # supply_sensor.hum [Pa]
    supply_sensor__hum_frequency: float | str  # supply_sensor.hum_frequency [Hz]
    supply_sensor__delay: float | str  # supply_sensor.delay [s]
    supply_sensor__lowest: float | str  # supply_sensor.lowest [Pa]
    supply_sensor__highest: float | str  # supply_sensor.highest [Pa]
    supply_sensor__bits: Any  # supply_sensor.bits
    position_sensor__order: Any  # position_sensor.order
    position_sensor__bandwidth: float | str  # position_sensor.bandwidth [Hz]
    position_sensor__damping_ratio: float | str  # position_sensor.damping_ratio
    position_sensor__noise: float | str  # position_sensor.noise [m]
    position_sensor__noise_bandwidth: float | str  # position_sensor.noise_bandwidth [Hz]
    position_sensor__noise_density: float | str  # position_sensor.noise_density [m/Hz^0.5]
    position_sensor__bias: float | str  # position_sensor.bias [m]
    position_sensor__drift: float | str  # position_sensor.drift [m/s]
    position_sensor__gain_error: float | str  # position_sensor.gain_error
    position_sensor__hum: float | str  # position_sensor.hum [m]
    position_sensor__hum_frequency: float | str  # position_sensor.hum_frequency [Hz]
    position_sensor__delay: float | str  # position_sensor.delay [s]
    position_sensor__lowest: float | str  # position_sensor.lowest [m]
    position_sensor__highest: float | str  # position_sensor.highest [m]
    position_sensor__bits: Any  # position_sensor.bits
    velocity_sensor__order: Any  # velocity_sensor.order
    velocity_sensor__bandwidth: float | str  # velocity_sensor.bandwidth [Hz]
    velocity_sensor__damping_ratio: float | str  # velocity_sensor.damping_ratio
    velocity_sensor__noise: float | str  # velocity_sensor.noise [m/s]
    velocity_sensor__noise_bandwidth: float | str  # velocity_sensor.noise_bandwidth [Hz]
    velocity_sensor__noise_density: float | str  # velocity_sensor.noise_density [m/s/Hz^0.5]
    velocity_sensor__bias: float | str  # velocity_sensor.bias [m/s]
    velocity_sensor__drift: float | str  # velocity_sensor.drift [m/s²]
    velocity_sensor__gain_error: float | str  # velocity_sensor.gain_error
    velocity_sensor__hum: float | str  # velocity_sensor.hum [m/s]
    velocity_sensor__hum_frequency: float | str  # velocity_sensor.hum_frequency [Hz]
    velocity_sensor__delay: float | str  # velocity_sensor.delay [s]
    velocity_sensor__lowest: float | str  # velocity_sensor.lowest [m/s]
    velocity_sensor__highest: float | str  # velocity_sensor.highest [m/s]
    velocity_sensor__bits: Any  # velocity_sensor.bits
    spool_sensor__order: Any  # spool_sensor.order
    spool_sensor__bandwidth: float | str  # spool_sensor.bandwidth [Hz]
    spool_sensor__damping_ratio: float | str  # spool_sensor.damping_ratio
    spool_sensor__noise: float | str  # spool_sensor.noise [m]
    spool_sensor__noise_bandwidth: float | str  # spool_sensor.noise_bandwidth [Hz]
    spool_sensor__noise_density: float | str  # spool_sensor.noise_density [m/Hz^0.5]
    spool_sensor__bias: float | str  # spool_sensor.bias [m]
    spool_sensor__drift: float | str  # spool_sensor.drift [m/s]
    spool_sensor__gain_error: float | str  # spool_sensor.gain_error
    spool_sensor__hum: float | str  # spool_sensor.hum [m]
    spool_sensor__hum_frequency: float | str  # spool_sensor.hum_frequency [Hz]
    spool_sensor__delay: float | str  # spool_sensor.delay [s]
    spool_sensor__lowest: float | str  # spool_sensor.lowest [m]
    spool_sensor__highest: float | str  # spool_sensor.highest [m]
    spool_sensor__bits: Any  # spool_sensor.bits
    voltage_sensor__order: Any  # voltage_sensor.order
    voltage_sensor__bandwidth: float | str  # voltage_sensor.bandwidth [Hz]
    voltage_sensor__damping_ratio: float | str  # voltage_sensor.damping_ratio
    voltage_sensor__noise: float | str  # voltage_sensor.noise [V]
    voltage_sensor__noise_bandwidth: float | str  # voltage_sensor.noise_bandwidth [Hz]
    voltage_sensor__noise_density: float | str  # voltage_sensor.noise_density [V/Hz^0.5]
    voltage_sensor__bias: float | str  # voltage_sensor.bias [V]
    voltage_sensor__drift: float | str  # voltage_sensor.drift [V/s]
    voltage_sensor__gain_error: float | str  # voltage_sensor.gain_error
    voltage_sensor__hum: float | str  # voltage_sensor.hum [V]
    voltage_sensor__hum_frequency: float | str  # voltage_sensor.hum_frequency [Hz]
    voltage_sensor__delay: float | str  # voltage_sensor.delay [s]
    voltage_sensor__lowest: float | str  # voltage_sensor.lowest [V]
    voltage_sensor__highest: float | str  # voltage_sensor.highest [V]
    voltage_sensor__bits: Any  # voltage_sensor.bits
    temperature_sensor__order: Any  # temperature_sensor.order
    temperature_sensor__bandwidth: float | str  # temperature_sensor.bandwidth [Hz]
    temperature_sensor__damping_ratio: float | str  # temperature_sensor.damping_ratio
    temperature_sensor__noise: float | str  # temperature_sensor.noise [K]
    temperature_sensor__noise_bandwidth: float | str  # temperature_sensor.noise_bandwidth [Hz]
    temperature_sensor__noise_density: float | str  # temperature_sensor.noise_density [K/Hz^0.5]
    temperature_sensor__bias: float | str  # temperature_sensor.bias [K]
    temperature_sensor__drift: float | str  # temperature_sensor.drift [K/s]
    temperature_sensor__gain_error: float | str  # temperature_sensor.gain_error
    temperature_sensor__hum: float | str  # temperature_sensor.hum [K]
    temperature_sensor__hum_frequency: float | str  # temperature_sensor.hum_frequency [Hz]
    temperature_sensor__delay: float | str  # temperature_sensor.delay [s]
    temperature_sensor__lowest: float | str  # temperature_sensor.lowest [K]
    temperature_sensor__highest: float | str  # temperature_sensor.highest [K]
    temperature_sensor__bits: Any  # temperature_sensor.bits
    wavelet__name: Any  # wavelet.name
    m: float | str  # actuator.mass [kg]
    M: float | str  # actuator.mass [kg]
    A: float | str  # actuator.piston_area [m²]
    A_1: float | str  # actuator.piston_area [m²]
    A1: float | str  # actuator.piston_area [m²]
    A_2: float | str  # actuator.piston_area_2 [m²]
    A2: float | str  # actuator.piston_area_2 [m²]
    V: float | str  # actuator.chamber_volume [m³]
    V_1: float | str  # actuator.chamber_volume [m³]
    V1: float | str  # actuator.chamber_volume [m³]
    V_2: float | str  # actuator.chamber_volume_2 [m³]
    V2: float | str  # actuator.chamber_volume_2 [m³]
    K_ex: float | str  # actuator.load_stiffness [N/m]
    P_s: float | str  # supply.pressure [Pa]
    Ps: float | str  # supply.pressure [Pa]
    p_s: float | str  # supply.pressure [Pa]
    P_r: float | str  # supply.return_pressure [Pa]
    Pr: float | str  # supply.return_pressure [Pa]
    p_r: float | str  # supply.return_pressure [Pa]
    EBM: float | str  # fluid.bulk_modulus [Pa]
    ebm: float | str  # fluid.bulk_modulus [Pa]
    beta: float | str  # fluid.bulk_modulus [Pa]
    beta_e: float | str  # fluid.bulk_modulus [Pa]
    β: float | str  # fluid.bulk_modulus [Pa]
    K_v: float | str  # valve.flow_gain [m^1.5/kg^0.5]
    w: float | str  # valve.area_gradient [m]
    k_v: float | str  # valve.spool_gain [m/V]
    f_v: float | str  # valve.natural_frequency [Hz]
    xi: float | str  # valve.damping_ratio
    ξ: float | str  # valve.damping_ratio
    F_c: float | str  # friction.coulomb [N]
    F_brk: float | str  # friction.breakaway [N]
    f: float | str  # friction.viscous [N·s/m]
    c_v: float | str  # friction.transition [s/m]
    v_th: float | str  # friction.velocity_threshold [m/s]
    K_i: float | str  # leakage.internal_coefficient [m³/s/√Pa]
    Ki: float | str  # leakage.internal_coefficient [m³/s/√Pa]
    q_il: float | str  # leakage.internal_flow [m³/s]
    q_i: float | str  # leakage.internal_flow [m³/s]
    K_e: float | str  # leakage.external_coefficient [m³/(s·Pa)]
    Ke: float | str  # leakage.external_coefficient [m³/(s·Pa)]
    U: float | str  # input.amplitude [V]
    T: float | str  # input.period [s]
    K_p: float | str  # control.proportional_gain [V/m]
    h: float | str  # record.step [s]
    dt: float | str  # record.step [s]
    f_s: float | str  # record.sampling_frequency [Hz]
    fs: float | str  # record.sampling_frequency [Hz]
    actuator: Any
    supply: Any
    fluid: Any
    valve: Any
    supply_1_edge: Any
    return_1_edge: Any
    supply_2_edge: Any
    return_2_edge: Any
    friction: Any
    leakage: Any
    input: Any
    control: Any
    load: Any
    record: Any
    measurement: Any
    pressure_1_sensor: Any
    pressure_2_sensor: Any
    supply_sensor: Any
    position_sensor: Any
    velocity_sensor: Any
    spool_sensor: Any
    voltage_sensor: Any
    temperature_sensor: Any
    plant: Any
    analysis: Any
    wavelet: Any
    name: Any
    plugins: Any
    indicators: Any
    baseline: Any
    calibration: Any
    sweep: Any
    store: Any
    units: Any
    limits: Any
    ensemble: Any
    study: Any
    detection: Any
    paper: Any
    claims: Any
    grid: Any
    zip: Any
    sample: Any
    union: Any
    where: Any
