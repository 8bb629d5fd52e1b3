/* The paper's valve and cylinder, equations (2) to (12), integrated by classic Runge-Kutta steps of 0.1 ms at most.

   All values are in SI and in one array, whose places are the value references: variables.h is made by building.py. */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "variables.h"

#define EXPORT __attribute__((visibility("default")))
#define N_STATE 6

typedef enum { OK, FAILED, DISCARDED } Result;
typedef enum { INSTANTIATED, INITIALIZING, RUNNING } Phase;

typedef struct {
    double v[N_VARIABLE];
    char text[64];
    double time, stop;
    Phase phase;
    int is_stale;
} Model;

static const int STATES[N_STATE] = {X, V, CYL_PORT_A_P, CYL_PORT_B_P, VALVE_X, VALVE_V};
static const int DERIVATIVES[N_STATE] = {DER_X_, DER_V_, DER_CYL_PORT_A_P_, DER_CYL_PORT_B_P_, DER_VALVE_X_, DER_VALVE_V_};

static double signed_root(double value) { return copysign(sqrt(fabs(value)), value); }

static double friction(const double *p, double velocity) {
    double threshold = p[FRICTION_THRESHOLD], speed = fmax(fabs(velocity), threshold);
    double dry = p[FRICTION_COULOMB] + (p[FRICTION_BREAKAWAY] - p[FRICTION_COULOMB]) * exp(-p[FRICTION_DECAY] * speed);
    if (p[FRICTION_LAW] != 1.0) dry = 0.0;
    return p[FRICTION_VISCOUS] * velocity + dry * fmin(fmax(velocity / threshold, -1.0), 1.0); /* (12) */
}

static double internal_leakage(const double *p, double p1, double p2) { return p[SEAL_K] * signed_root(p1 - p2); } /* (11) */

static void rates(const double *p, const double *y, double *rate) {
    double x = y[0], v = y[1], p1 = y[2], p2 = y[3], opening = y[4], area = p[CYL_AREA];
    double supply = p[SUPPLY_P], ret = p[SUPPLY_RET], flow = p[VALVE_K] * p[VALVE_W] * opening, w = p[VALVE_OMEGA];
    double q1 = flow * signed_root(opening >= 0.0 ? supply - p1 : p1 - ret); /* (7) */
    double q2 = flow * signed_root(opening >= 0.0 ? p2 - ret : supply - p2); /* (8) */
    double leak = internal_leakage(p, p1, p2);
    double spring = p[LOAD_ON] != 0.0 ? p[LOAD_STIFFNESS] * x : 0.0;
    rate[0] = v;
    rate[1] = (area * (p1 - p2) - friction(p, v) - spring) / p[CYL_MASS]; /* (2) */
    rate[2] = p[OIL_BETA] / (p[CYL_VOLUME] + area * x) * (q1 - leak - p[CYL_K_EXT_1_] * p1 - area * v); /* (5) */
    rate[3] = p[OIL_BETA] / (p[CYL_VOLUME] - area * x) * (leak - q2 - p[CYL_K_EXT_2_] * p2 + area * v); /* (6) */
    rate[4] = y[5];
    rate[5] = w * w * (p[VALVE_GAIN] * p[U] - opening) - 2.0 * p[VALVE_XI] * w * y[5]; /* (4) */
}

/* Derivatives and outputs that follow from the states. */
static void refresh(Model *m) {
    double y[N_STATE], rate[N_STATE];
    if (!m->is_stale) return;
    m->is_stale = 0;
    for (int k = 0; k < N_STATE; k++) y[k] = m->v[STATES[k]];
    rates(m->v, y, rate);
    for (int k = 0; k < N_STATE; k++) m->v[DERIVATIVES[k]] = rate[k];
    m->v[Q_LEAK] = internal_leakage(m->v, y[2], y[3]);
    m->v[SUPPLY_PORT_P] = m->v[SUPPLY_P];
}

static void restart(Model *m) {
#ifndef FALSE_RESET
    m->phase = INSTANTIATED;
#endif
    if (m->phase == INSTANTIATED) memcpy(m->v, START, sizeof START);
    strcpy(m->text, "HLP32");
    m->time = 0.0;
    m->stop = INFINITY;
    m->phase = INSTANTIATED;
    m->is_stale = 1;
}

/* At rest in the centre, with the pressures of a closed servovalve. */
static void initialize(Model *m) {
    m->v[CYL_P_REST] = 0.5 * (m->v[SUPPLY_P] + m->v[SUPPLY_RET]);
    m->v[CYL_PORT_A_P] = m->v[CYL_PORT_B_P] = m->v[CYL_P_REST];
    m->phase = RUNNING;
    m->is_stale = 1;
}

static int is_due(const Model *m, int hazard, double end) { return m->v[hazard] >= 0.0 && m->v[hazard] < end - 1e-9; }

static const char *failure = "";

static Result advance(Model *m, double time, double length) {
    double y[N_STATE], z[N_STATE], r[4][N_STATE];
    int n = (int)ceil(length / 1e-4 - 1e-6);
    if (m->phase != RUNNING || fabs(time - m->time) > 1e-9 || length <= 0.0) {
        failure = "a step must begin where the last one ended";
        return FAILED;
    }
    double end = time + length, h = length / n;
    if (end > m->stop + 1e-9) {
        failure = "a step must not go beyond the stop time";
        return FAILED;
    }
#ifdef CHATTY
    if (time < 1e-9) puts("the plant runs");
    fflush(stdout);
#endif
    if (is_due(m, HAZARD_CRASH, end)) raise(SIGSEGV);
    for (volatile int hangs = is_due(m, HAZARD_HANG, end); hangs;) {}
    if (is_due(m, HAZARD_FAIL, end)) {
        failure = "the solver of the plant gave up";
        return FAILED;
    }
    if (is_due(m, HAZARD_DISCARD, end)) {
        failure = "the step is too long for the plant";
        return DISCARDED;
    }
    for (int k = 0; k < N_STATE; k++) y[k] = m->v[STATES[k]];
    for (int i = 0; i < n; i++) {
        const double parts[3] = {0.5 * h, 0.5 * h, h};
        rates(m->v, y, r[0]);
        for (int stage = 0; stage < 3; stage++) {
            for (int k = 0; k < N_STATE; k++) z[k] = y[k] + parts[stage] * r[stage][k];
            rates(m->v, z, r[stage + 1]);
        }
        for (int k = 0; k < N_STATE; k++) {
            y[k] += h / 6.0 * (r[0][k] + 2.0 * (r[1][k] + r[2][k]) + r[3][k]);
            if (fabs(y[k]) < 1e-100) y[k] = 0.0; /* a decay would end in slow subnormal numbers */
        }
    }
    if (is_due(m, HAZARD_NAN, end)) y[2] = NAN;
    for (int k = 0; k < N_STATE; k++) m->v[STATES[k]] = y[k];
    m->time = end;
    m->is_stale = 1;
    return OK;
}

/* Value in the unit that modelDescription.xml declares. */
static double get(Model *m, unsigned reference) {
    refresh(m);
    return m->v[reference] / SCALE[reference];
}

/* Inputs and tunable parameters may be set at any time, fixed parameters and start values only before the end of
   initialization. */
static Result set(Model *m, unsigned reference, double value) {
    char kind = reference < N_VARIABLE ? KIND[reference] : '-';
    if (!strchr(m->phase == RUNNING ? "it" : "itfs", kind)) {
        failure = "this variable cannot be set now";
        return FAILED;
    }
    m->v[reference] = value * SCALE[reference];
    m->is_stale = 1;
    return OK;
}
