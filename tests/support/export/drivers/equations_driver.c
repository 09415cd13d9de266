/* Calls the equations of an axis in random order, in either version of FMI, and compares what each call says
   and does with the states of FMI's model exchange. */
#include "driver.h"
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef FMI2_FUNCTION_PREFIX
#define FMI(name) fmi2##name
#define DERIVATIVES fmi2GetDerivatives
#define STATE(name) fmi2##name##FMUstate
#define STATE_SIZE fmi2SerializedFMUstateSize
#define DESERIALIZE fmi2DeSerializeFMUstate
typedef fmi2Component component;
typedef fmi2FMUstate saved_state;
#else
#define FMI(name) fmi3##name
#define DERIVATIVES fmi3GetContinuousStateDerivatives
#define STATE(name) fmi3##name##FMUState
#define STATE_SIZE fmi3SerializedFMUStateSize
#define DESERIALIZE fmi3DeserializeFMUState
typedef fmi3Instance component;
typedef fmi3FMUState saved_state;
#endif

#define CALLS 300000
#define MOST_BYTES 4096
#define ROUNDED (1.0 - 3.0 * DBL_EPSILON) /* from this part of its time on the load has jumped */

enum mode { NEW = 1, INITIAL = 2, EVENT = 4, CONTINUOUS = 8, ENDED = 16, WRONG = 32 };
enum status { OK, WARNING, DISCARD, ERROR };
#define BEFORE_EVENTS (NEW | INITIAL)
#define ANY (NEW | INITIAL | EVENT | CONTINUOUS | ENDED | WRONG)

/* What the instance must think of itself. */
typedef struct {
    enum mode mode;
    int between;  /* the events, so that the next one's jump is not seen */
    double start; /* [s] */
    double time;  /* [s] */
    double jump;  /* [s] when an update said that the load jumps, since the start */
    double next;  /* [s] the same in the importer's time */
    double x[MODEL_STATES];
} belief;

static component c;
static belief now, kept;
static saved_state saved;
static int jumps, steps;
static uint64_t drawn = 1;
static double load_time, hydraulic_force[2], first[MODEL_STATES];

static const double starts[] = {0.0, 2.0, 0.1, -3.0, 1e6};
static const double values[] = {0.0, -0.1, 0.2, 0.3, 2.0, 1e308, -1e308, 5e-324, INFINITY, NAN};

static unsigned draw(unsigned count) {
    drawn = drawn * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (unsigned)((drawn >> 33) % count);
}

static void must(int right, const char *what) {
    if (!right) {
        printf("wrong: %s, in mode %d at %.17g s, started at %g s\n", what, (int)now.mode, now.time,
               now.start);
        exit(1);
    }
}

static unsigned reference(const char *name) {
    unsigned found = 0;
    while (found < MODEL_VARIABLES && strcmp(model_variables[found].name, name) != 0) {
        found++;
    }
    must(found < MODEL_VARIABLES, name);
    return found;
}

static int same(const double *one, const double *other, size_t count) {
    return memcmp(one, other, count * sizeof *one) == 0;
}

/* --- what differs between the versions --- */

#ifdef FMI2_FUNCTION_PREFIX
static component instance(void) {
    static const fmi2CallbackFunctions callbacks = {count, NULL, NULL, NULL, NULL};
    return fmi2Instantiate("a", fmi2ModelExchange, MODEL_TOKEN, NULL, &callbacks, fmi2False, fmi2True);
}

static int initialize(double start) {
    if (now.mode != NEW && draw(2)) {
        return (int)fmi2EnterInitializationMode(c);
    }
    const fmi2Status status = fmi2SetupExperiment(c, fmi2False, 0.0, start, fmi2False, 0.0);
    return (int)(status == fmi2OK ? fmi2EnterInitializationMode(c) : status);
}

static int get(unsigned from, double *value) {
    return (int)fmi2GetReal(c, &from, 1, value);
}

static int set(unsigned into, double value) {
    return (int)fmi2SetReal(c, &into, 1, &value);
}

static int update(double *next) {
    fmi2EventInfo events;
    const fmi2Status status = fmi2NewDiscreteStates(c, &events);
    *next = status == fmi2OK && events.nextEventTimeDefined ? events.nextEventTime : (double)INFINITY;
    return (int)status;
}

static int lacking(void) {
    const fmi2ValueReference some[] = {1};
    fmi2Integer whole = 0;
    return (int)(draw(2) ? fmi2GetInteger(c, some, 1, &whole) : fmi2SetInteger(c, some, 1, &whole));
}
#else
static component instance(void) {
    return fmi3InstantiateModelExchange("a", MODEL_TOKEN, NULL, fmi3False, fmi3True, NULL, count);
}

static int initialize(double start) {
    return (int)fmi3EnterInitializationMode(c, fmi3False, 0.0, start, fmi3False, 0.0);
}

static int get(unsigned from, double *value) {
    return (int)fmi3GetFloat64(c, &from, 1, value, 1);
}

static int set(unsigned into, double value) {
    return (int)fmi3SetFloat64(c, &into, 1, &value, 1);
}

static int update(double *next) {
    fmi3Boolean needed, ended, nominals, continuous, defined;
    const fmi3Status status =
        fmi3UpdateDiscreteStates(c, &needed, &ended, &nominals, &continuous, &defined, next);
    *next = status == fmi3OK && defined ? *next : (double)INFINITY;
    return (int)status;
}

static int lacking(void) {
    fmi3Boolean events, ended, early;
    double last;
    return (int)(draw(2) ? fmi3EnterStepMode(c)
                         : fmi3DoStep(c, now.time, 1e-3, fmi3True, &events, &ended, &early, &last));
}
#endif

/* --- calls --- */

/* Whether a call was taken. It may come in these modes, and is discarded there where its values are wrong. */
static int taken(int status, unsigned modes, int right, const char *what) {
    const int allowed = ((unsigned)now.mode & modes) != 0;
    must(status == (!allowed ? ERROR : right ? OK : DISCARD), what);
    must((status == OK) == (messages == 0), "each refusal is said");
    messages = 0;
    if (!allowed) {
        now.mode = WRONG;
    }
    return allowed && right;
}

static void begin(void) {
    const double start = starts[draw(5)];
    if (taken(initialize(start), NEW, 1, "initialize")) {
        now.mode = INITIAL;
        now.start = now.time = start;
    }
}

static void leave_initialization(void) {
    if (taken((int)FMI(ExitInitializationMode)(c), INITIAL, 1, "initialized")) {
        now.mode = EVENT;
    }
}

/* Whether the load has jumped, which is not seen before the event. */
static int jumped(void) {
    const double passed = now.time - now.start;
    return (!now.between || now.jump != load_time) && passed >= ROUNDED * load_time;
}

static void renew(void) {
    double next;
    if (taken(update(&next), EVENT, 1, "update")) {
        now.next = next;
        now.jump = jumped() ? (double)INFINITY : load_time;
        must(isfinite(next) != jumped(), "a jump that is still to come is announced");
        must(jumped() || (next > now.time && next - now.start >= load_time),
             "an event is late enough to be one");
        must(jumped() || fabs(next - now.start - load_time) < 1e-9,
             "an event is not later than it has to be");
    }
}

static void enter_events(void) {
    if (taken((int)FMI(EnterEventMode)(c), EVENT | CONTINUOUS, 1, "enter the event mode")) {
        now.mode = EVENT;
        now.between = 0;
    }
}

static void enter_continuous(void) {
    if (taken((int)FMI(EnterContinuousTimeMode)(c), EVENT, 1, "enter the continuous-time mode")) {
        now.mode = CONTINUOUS;
        now.between = 1;
    }
}

static void set_time(double time) {
    if (taken((int)FMI(SetTime)(c, time), isfinite(time) ? EVENT | CONTINUOUS : 0, 1, "set the time")) {
        now.time = time;
    }
}

static void set_states(const double *x) {
    int right = 1;
    for (unsigned i = 0; i < MODEL_STATES; i++) {
        right = right && !isnan(x[i]);
    }
    if (taken((int)FMI(SetContinuousStates)(c, x, MODEL_STATES), CONTINUOUS, right, "set the states")) {
        memcpy(now.x, x, sizeof now.x);
    }
}

static void set_one_state(double value) {
    const unsigned i = draw(MODEL_STATES);
    if (taken(set(model_states[i], value), CONTINUOUS, !isnan(value), "set a state by its reference")) {
        now.x[i] = value;
    }
}

static void set_start(double value) {
    const int right = value >= 0.0 && isfinite(value);
    if (taken(set(reference("plant.start_position"), value), BEFORE_EVENTS, right, "set a fixed parameter")) {
        for (unsigned i = 0; i < MODEL_STATES; i++) {
            now.x[i] = model_states[i] == reference("plant.position") ? value : now.x[i];
        }
    }
}

static void complete(void) {
    FMI(Boolean) enter, end;
    (void)taken((int)FMI(CompletedIntegratorStep)(c, FMI(True), &enter, &end), CONTINUOUS, 1,
                "complete a step");
}

/* What never is right. */
static void mistake(void) {
    double numbers[MODEL_STATES + 1] = {0.0};
    const unsigned computed[] = {0, model_rates[0], reference("load.force")};
    switch (draw(7)) {
    case 0:
        (void)taken(lacking(), 0, 1, "a call of another kind of FMU");
        break;
    case 1:
        (void)taken(set(computed[draw(3)], 0.5), 0, 1, "set what is computed");
        break;
    case 2:
        (void)taken(get(MODEL_VARIABLES + draw(3), numbers), 0, 1, "get what is not there");
        break;
    case 3:
        (void)taken((int)FMI(GetContinuousStates)(c, numbers, MODEL_STATES - 1 + 2 * draw(2)), 0, 1,
                    "too few states, or too many");
        break;
    case 4:
        (void)taken((int)FMI(SetContinuousStates)(c, NULL, MODEL_STATES), 0, 1, "no states");
        break;
    case 5:
        (void)taken((int)FMI(GetEventIndicators)(c, numbers, 1), 0, 1, "event indicators");
        break;
    default:
        (void)taken((int)STATE(Set)(c, NULL), 0, 1, "restore nothing");
    }
}

static void call(void) {
    const double value = values[draw(10)];
    double x[MODEL_STATES];
    switch (draw(16)) {
    case 0:
        begin();
        break;
    case 1:
        leave_initialization();
        break;
    case 2:
        renew();
        break;
    case 3:
        enter_events();
        break;
    case 4:
        enter_continuous();
        break;
    case 5:
        complete();
        break;
    case 6:
        set_time(draw(9) ? now.start + 0.25 * draw(9) * load_time : value);
        break;
    case 7:
        memcpy(x, now.x, sizeof x);
        x[draw(MODEL_STATES)] = value;
        set_states(x);
        break;
    case 8:
        set_one_state(value);
        break;
    case 9:
    case 10:
        (void)taken(set(reference("controller.u"), value), BEFORE_EVENTS | EVENT | CONTINUOUS, 1,
                    "set an input");
        break;
    case 11:
        (void)taken(set(reference("plant.mechanism.mass"), value), BEFORE_EVENTS | EVENT,
                    value > 0.0 && isfinite(value), "set a tunable parameter");
        break;
    case 12:
        set_start(value);
        break;
    case 13:
        if (taken((int)FMI(Terminate)(c), EVENT | CONTINUOUS, 1, "terminate")) {
            now.mode = ENDED;
        }
        break;
    default:
        mistake();
    }
}

/* --- what must hold after each call --- */

/* The rates, and whether all are finite. */
static int rates_of(double *rates) {
    int finite = 1;
    const int status = (int)DERIVATIVES(c, rates, MODEL_STATES);
    for (unsigned i = 0; i < MODEL_STATES; i++) {
        finite = finite && isfinite(rates[i]);
    }
    (void)taken(status, ANY, finite, "rates are discarded where they are not finite, and there alone");
    return finite;
}

static void look(void) {
    double x[MODEL_STATES], rates[MODEL_STATES], again[MODEL_STATES], sizes[MODEL_STATES], time, force;
    must((int)FMI(GetContinuousStates)(c, x, MODEL_STATES) == OK && same(x, now.x, MODEL_STATES),
         "the states");
    must(get(0, &time) == OK && same(&time, &now.time, 1), "the time");
    must(get(reference("load.force"), &force) == OK, "get the load");
    must(force == hydraulic_force[jumped()], "the load is that of the last event");
    must((int)FMI(GetNominalsOfContinuousStates)(c, sizes, MODEL_STATES) == OK && sizes[0] > 0.0, "nominals");
    if (rates_of(rates)) {
        must(rates_of(again) && same(rates, again, MODEL_STATES), "rates are the same if asked for again");
        for (unsigned i = 0; i < MODEL_STATES; i++) {
            must(get(model_rates[i], &time) == OK && same(&time, &rates[i], 1), "rates by their references");
        }
    }
}

/* A state goes out as bytes and comes back. */
static void carry(void) {
    FMI(Byte) bytes[MOST_BYTES];
    size_t size;
    must((int)STATE_SIZE(c, saved, &size) == OK && size <= MOST_BYTES, "how many bytes");
    must((int)STATE(Serialize)(c, saved, bytes, size) == OK, "into bytes");
    must((int)STATE(Free)(c, &saved) == OK && saved == NULL, "free a state");
    must((int)DESERIALIZE(c, bytes, size, &saved) == OK, "from bytes");
}

/* A step of Euler's method as an importer should take it, and no further than the next event. */
static void step(void) {
    double x[MODEL_STATES], rates[MODEL_STATES];
    const double time = now.time + 0.1 * load_time;
    if (!rates_of(rates)) {
        return;
    }
    for (unsigned i = 0; i < MODEL_STATES; i++) {
        x[i] = now.x[i] + 1e-6 * rates[i];
    }
    set_time(now.next > now.time && time > now.next ? now.next : time);
    set_states(x);
    complete();
    steps++;
    if (now.time == now.next && now.jump == load_time) {
        enter_events();
        must(jumped(), "the load jumps at the event that was announced");
        look();
        renew();
        must(now.next > now.time, "no event comes twice");
        enter_continuous();
        jumps++;
    }
}

/* A call that is right, so that random ones come everywhere in a run. */
static void go_on(void) {
    if (now.mode == NEW) {
        begin();
    } else if (now.mode == INITIAL) {
        leave_initialization();
    } else if (now.mode == EVENT) {
        renew();
        enter_continuous();
    } else if (now.mode == CONTINUOUS) {
        step();
    } else if (now.mode == WRONG) {
        carry();
        must((int)STATE(Set)(c, saved) == OK, "restore after an error");
        now = kept;
    }
}

static void start_again(void) {
    must((int)FMI(Reset)(c) == OK, "reset");
    now = (belief){.mode = NEW, .jump = INFINITY, .next = INFINITY};
    memcpy(now.x, first, sizeof first);
}

static void keep(void) {
    must((int)STATE(Get)(c, &saved) == OK, "save");
    kept = now;
}

int main(void) {
    c = instance();
    must(c != NULL, "instantiate");
    must(get(reference("load.time"), &load_time) == OK &&
             get(reference("load.initial"), &hydraulic_force[0]) == OK &&
             get(reference("load.final"), &hydraulic_force[1]) == OK &&
             hydraulic_force[0] != hydraulic_force[1],
         "the load");
    must((int)FMI(GetContinuousStates)(c, first, MODEL_STATES) == OK, "the states at the start");
    start_again();
    keep();
    for (int k = 0; k < CALLS; k++) {
        if (draw(4) == 0) {
            call();
        } else {
            go_on();
        }
        look();
        if (now.mode == ENDED || draw(100) == 0) {
            start_again();
        }
        if (now.mode != WRONG && draw(10) == 0) {
            keep();
        }
    }
    must((int)STATE(Free)(c, &saved) == OK, "free a state");
    FMI(FreeInstance)(c);
    must(steps > CALLS / 5 && jumps > CALLS / 200,
         "many calls came where an importer integrates, and at events");
    printf("%d calls\n", CALLS);
    return 0;
}
