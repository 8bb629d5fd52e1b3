/* FMI 3.0, co-simulation, around the model of cylinder.c. */
#include "fmi3FunctionTypes.h"

#include "cylinder.c"

typedef struct {
    Model model;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Instance;

static fmi3Status told(Instance *i, Result result) {
    fmi3Status status = result == OK ? fmi3OK : result == FAILED ? fmi3Error : fmi3Discard;
    if (result != OK && i->log) i->log(i->environment, status, "logStatusError", failure);
    return status;
}

#define MODEL(c) (&((Instance *)(c))->model)
#define ABSENT(name) EXPORT fmi3Status name(void) { return fmi3Error; }
#define PLAIN(name, statement) EXPORT fmi3Status name(fmi3Instance c) { statement; return fmi3OK; }
/* The variable `cyl.k_ext` is an array of two. */
#define EACH_VALUE(k, j) \
    for (size_t k = 0, j = 0, part = 0; k < n && j < n_value; j++, part = r[k] == CYL_K_EXT_1_ && !part, k += !part)
#define GETTER(name, type, number)                                                                                          \
    EXPORT fmi3Status name(fmi3Instance c, const fmi3ValueReference r[], size_t n, type values[], size_t n_value) {         \
        EACH_VALUE(k, j) {                                                                                                  \
            if (r[k] >= N_VARIABLE) return fmi3Error;                                                                       \
            values[j] = number;                                                                                             \
        }                                                                                                                   \
        return fmi3OK;                                                                                                      \
    }
#define SETTER(name, type)                                                                                                  \
    EXPORT fmi3Status name(fmi3Instance c, const fmi3ValueReference r[], size_t n, const type values[], size_t n_value) {   \
        EACH_VALUE(k, j)                                                                                                    \
            if (set(MODEL(c), r[k] + (unsigned)part, (double)values[j]) != OK) return told(c, FAILED);                      \
        return fmi3OK;                                                                                                      \
    }

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }
EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]) { return fmi3OK; }

EXPORT fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logs, fmi3Boolean events,
    fmi3Boolean early, const fmi3ValueReference required[], size_t n, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    if (strcmp(token, GUID)) return NULL;
    Instance *i = calloc(1, sizeof *i);
    i->log = log;
    i->environment = environment;
    restart(&i->model);
    return i;
}

EXPORT void fmi3FreeInstance(fmi3Instance c) { free(c); }

EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                              fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop) {
    MODEL(c)->time = start;
    if (has_stop) MODEL(c)->stop = stop;
    MODEL(c)->phase = INITIALIZING;
    return fmi3OK;
}

PLAIN(fmi3ExitInitializationMode, initialize(MODEL(c)))
PLAIN(fmi3Terminate, )
PLAIN(fmi3EnterEventMode, )
PLAIN(fmi3EnterStepMode, )
#ifdef NO_RESET
ABSENT(fmi3Reset)
#else
PLAIN(fmi3Reset, restart(MODEL(c)))
#endif

GETTER(fmi3GetFloat64, fmi3Float64, get(MODEL(c), r[k] + (unsigned)part))
GETTER(fmi3GetInt64, fmi3Int64, (fmi3Int64)get(MODEL(c), r[k]))
GETTER(fmi3GetBoolean, fmi3Boolean, get(MODEL(c), r[k]) != 0.0)
GETTER(fmi3GetString, fmi3String, MODEL(c)->text)
SETTER(fmi3SetFloat64, fmi3Float64)
SETTER(fmi3SetInt64, fmi3Int64)
SETTER(fmi3SetBoolean, fmi3Boolean)

EXPORT fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference r[], size_t n, const fmi3String values[], size_t n_value) {
    if (n_value) snprintf(MODEL(c)->text, sizeof MODEL(c)->text, "%s", values[n_value - 1]);
    return fmi3OK;
}

EXPORT fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 length, fmi3Boolean no_prior, fmi3Boolean *event,
                             fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *last) {
    Result result = advance(MODEL(c), time, length);
    *event = *ends = *early = fmi3False;
    *last = MODEL(c)->time;
    return told(c, result);
}

EXPORT fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *more, fmi3Boolean *ends, fmi3Boolean *nominals,
                                           fmi3Boolean *values, fmi3Boolean *has_next, fmi3Float64 *next) {
    *more = *ends = *nominals = *values = *has_next = fmi3False;
    return fmi3OK;
}

EXPORT fmi3Instance fmi3InstantiateModelExchange(void) { return NULL; }
EXPORT fmi3Instance fmi3InstantiateScheduledExecution(void) { return NULL; }
/* Importers look for all functions. */
ABSENT(fmi3GetFloat32) ABSENT(fmi3GetInt8) ABSENT(fmi3GetUInt8) ABSENT(fmi3GetInt16) ABSENT(fmi3GetUInt16) ABSENT(fmi3GetInt32)
ABSENT(fmi3GetUInt32) ABSENT(fmi3GetUInt64) ABSENT(fmi3GetBinary) ABSENT(fmi3GetClock) ABSENT(fmi3SetFloat32) ABSENT(fmi3SetInt8)
ABSENT(fmi3SetUInt8) ABSENT(fmi3SetInt16) ABSENT(fmi3SetUInt16) ABSENT(fmi3SetInt32) ABSENT(fmi3SetUInt32) ABSENT(fmi3SetUInt64)
ABSENT(fmi3SetBinary) ABSENT(fmi3SetClock) ABSENT(fmi3GetNumberOfVariableDependencies) ABSENT(fmi3GetVariableDependencies)
ABSENT(fmi3GetFMUState) ABSENT(fmi3SetFMUState) ABSENT(fmi3FreeFMUState) ABSENT(fmi3SerializedFMUStateSize)
ABSENT(fmi3SerializeFMUState) ABSENT(fmi3DeserializeFMUState) ABSENT(fmi3GetDirectionalDerivative) ABSENT(fmi3GetAdjointDerivative)
ABSENT(fmi3EnterConfigurationMode) ABSENT(fmi3ExitConfigurationMode) ABSENT(fmi3GetIntervalDecimal) ABSENT(fmi3GetIntervalFraction)
ABSENT(fmi3GetShiftDecimal) ABSENT(fmi3GetShiftFraction) ABSENT(fmi3SetIntervalDecimal) ABSENT(fmi3SetIntervalFraction)
ABSENT(fmi3SetShiftDecimal) ABSENT(fmi3SetShiftFraction) ABSENT(fmi3EvaluateDiscreteStates) ABSENT(fmi3EnterContinuousTimeMode)
ABSENT(fmi3CompletedIntegratorStep) ABSENT(fmi3SetTime) ABSENT(fmi3SetContinuousStates) ABSENT(fmi3GetContinuousStateDerivatives)
ABSENT(fmi3GetEventIndicators) ABSENT(fmi3GetContinuousStates) ABSENT(fmi3GetNominalsOfContinuousStates)
ABSENT(fmi3GetNumberOfEventIndicators) ABSENT(fmi3GetNumberOfContinuousStates) ABSENT(fmi3GetOutputDerivatives)
ABSENT(fmi3ActivateModelPartition)
