/* FMI 2.0, co-simulation and model exchange, around the model of cylinder.c. */
#include "fmi2FunctionTypes.h"

#include "cylinder.c"

typedef struct {
    Model model;
    const fmi2CallbackFunctions *call;
    char name[64];
} Instance;

static int n_instance = 0;

static fmi2Status told(Instance *i, Result result) {
    fmi2Status status = result == OK ? fmi2OK : result == FAILED ? fmi2Error : fmi2Discard;
    if (result != OK && i->call && i->call->logger)
        i->call->logger(i->call->componentEnvironment, i->name, status, "logStatusError", "%s", failure);
    return status;
}

#define MODEL(c) (&((Instance *)(c))->model)
#define ABSENT(name) EXPORT fmi2Status name(void) { return fmi2Error; }
#define PLAIN(name, statement) EXPORT fmi2Status name(fmi2Component c) { statement; return fmi2OK; }
#define GETTER(name, type, number)                                                                                      \
    EXPORT fmi2Status name(fmi2Component c, const fmi2ValueReference r[], size_t n, type values[]) {                    \
        for (size_t k = 0; k < n; k++) {                                                                                \
            if (r[k] >= N_VARIABLE) return fmi2Error;                                                                   \
            values[k] = number;                                                                                         \
        }                                                                                                               \
        return fmi2OK;                                                                                                  \
    }
#define SETTER(name, type)                                                                                              \
    EXPORT fmi2Status name(fmi2Component c, const fmi2ValueReference r[], size_t n, const type values[]) {              \
        for (size_t k = 0; k < n; k++)                                                                                  \
            if (set(MODEL(c), r[k], values[k]) != OK) return told(c, FAILED);                                           \
        return fmi2OK;                                                                                                  \
    }

EXPORT const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) { return fmi2OK; }

EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                     const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logs) {
    Instance *i = calloc(1, sizeof *i);
    i->call = call;
    snprintf(i->name, sizeof i->name, "%s", name);
    failure = strcmp(guid, GUID) ? "the GUID is of another model" : "";
#ifdef NO_LICENCE
    failure = "no licence was found";
#endif
#ifdef ONCE
    if (n_instance > 0) failure = "a second instance in one process";
#endif
    if (*failure) {
        told(i, FAILED);
        free(i);
        return NULL;
    }
    n_instance++;
    restart(&i->model);
    return i;
}

EXPORT void fmi2FreeInstance(fmi2Component c) {
    n_instance--;
    free(c);
}

EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                                      fmi2Boolean has_stop, fmi2Real stop) {
    MODEL(c)->time = start;
    if (has_stop) MODEL(c)->stop = stop;
    return fmi2OK;
}

PLAIN(fmi2EnterInitializationMode, MODEL(c)->phase = INITIALIZING)
PLAIN(fmi2ExitInitializationMode, initialize(MODEL(c)))
PLAIN(fmi2Terminate, )
#ifdef NO_RESET
ABSENT(fmi2Reset)
#else
PLAIN(fmi2Reset, restart(MODEL(c)))
#endif

GETTER(fmi2GetReal, fmi2Real, get(MODEL(c), r[k]))
GETTER(fmi2GetInteger, fmi2Integer, (int)get(MODEL(c), r[k]))
GETTER(fmi2GetBoolean, fmi2Boolean, get(MODEL(c), r[k]) != 0.0)
GETTER(fmi2GetString, fmi2String, MODEL(c)->text)
SETTER(fmi2SetReal, fmi2Real)
SETTER(fmi2SetInteger, fmi2Integer)
SETTER(fmi2SetBoolean, fmi2Boolean)

EXPORT fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String values[]) {
    if (n) snprintf(MODEL(c)->text, sizeof MODEL(c)->text, "%s", values[n - 1]);
    return fmi2OK;
}

EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real length, fmi2Boolean no_prior) {
    return told(c, advance(MODEL(c), time, length));
}

ABSENT(fmi2GetFMUstate) ABSENT(fmi2SetFMUstate) ABSENT(fmi2FreeFMUstate) ABSENT(fmi2SerializedFMUstateSize)
ABSENT(fmi2SerializeFMUstate) ABSENT(fmi2DeSerializeFMUstate) ABSENT(fmi2GetDirectionalDerivative)
ABSENT(fmi2SetRealInputDerivatives) ABSENT(fmi2GetRealOutputDerivatives) ABSENT(fmi2CancelStep) ABSENT(fmi2GetStatus)
ABSENT(fmi2GetRealStatus) ABSENT(fmi2GetIntegerStatus) ABSENT(fmi2GetStringStatus)

EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    *value = fmi2False;
    return fmi2OK;
}

/* Model exchange: the states are set by the solver of the importer. */
PLAIN(fmi2EnterEventMode, )
PLAIN(fmi2EnterContinuousTimeMode, )

EXPORT fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    memset(info, 0, sizeof *info);
    return fmi2OK;
}

EXPORT fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_prior, fmi2Boolean *event, fmi2Boolean *ends) {
    *event = *ends = fmi2False;
    return fmi2OK;
}

EXPORT fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    MODEL(c)->time = time;
    return fmi2OK;
}

EXPORT fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real values[], size_t n) {
    for (size_t k = 0; k < n; k++) MODEL(c)->v[STATES[k]] = values[k] * SCALE[STATES[k]];
    MODEL(c)->is_stale = 1;
    return fmi2OK;
}

static fmi2Status of_states(Model *m, const int places[], fmi2Real values[], size_t n) {
    refresh(m);
    for (size_t k = 0; k < n; k++) values[k] = m->v[places[k]] / SCALE[STATES[k]];
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real values[], size_t n) { return of_states(MODEL(c), STATES, values, n); }
EXPORT fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real values[], size_t n) { return of_states(MODEL(c), DERIVATIVES, values, n); }
EXPORT fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real values[], size_t n) { return fmi2OK; }

EXPORT fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real values[], size_t n) {
    static const double nominal[N_STATE] = {1e-2, 1e-1, 1e7, 1e7, 1e-5, 1e-2};
    for (size_t k = 0; k < n; k++) values[k] = nominal[k] / SCALE[STATES[k]];
    return fmi2OK;
}
