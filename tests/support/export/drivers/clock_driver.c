/* Calls the toy's PI with a clock in random order, and compares each answer with the states of FMI 3.0. */
#include "driver.h"
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#define CALLS 300000
#define QUARTER (0.25 * MODEL_PERIOD) /* [s] what times are counted in, so that they are exact */

enum mode { NEW = 1, INITIAL = 2, STEP = 4, EVENT = 8, TICK = 16, ENDED = 32, WRONG = 64 };

/* What the instance must think of itself. */
typedef struct {
    enum mode mode;
    long time; /* [QUARTER] */
    long due;  /* [QUARTER] */
} belief;

static fmi3Instance c;
static belief now, kept;
static fmi3FMUState saved;
static int ticks;
static uint64_t drawn = 1;

static const fmi3ValueReference velocity[] = {5}, integral[] = {8}, sample[] = {MODEL_CLOCK},
                                none[] = {MODEL_CLOCK + 1};
static const double values[] = {0.0, -0.1, 0.2, 0.3, 1e308, -1e308, 5e-324, INFINITY, NAN};
static const double sizes[] = {1.0, 2.0, 3.0, 4.0, 9.0}, no_sizes[] = {0.0, -4.0, INFINITY, NAN};

static unsigned draw(unsigned count) {
    drawn = drawn * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (unsigned)((drawn >> 33) % count);
}

static void must(int right, const char *what) {
    if (!right) {
        printf("wrong: %s, in mode %d at %ld, due at %ld\n", what, (int)now.mode, now.time, now.due);
        exit(1);
    }
}

/* A call that may come in these modes; returns whether it was taken. */
static int taken(fmi3Status status, unsigned modes, int allowed, const char *what) {
    const int right = ((unsigned)now.mode & modes) != 0 && allowed;
    must(right ? status <= fmi3Warning : status == fmi3Error, what);
    must((status == fmi3OK) == (messages == 0), "each refusal and warning is said");
    messages = 0;
    if (!right) {
        now.mode = WRONG;
    }
    return right;
}

static fmi3Status update(void) {
    fmi3Boolean needed, ended, nominals, continuous, defined;
    double next;
    return fmi3UpdateDiscreteStates(c, &needed, &ended, &nominals, &continuous, &defined, &next);
}

static void step(void) {
    const int wrong = draw(20) == 0;
    const double size = wrong ? no_sizes[draw(4)] : sizes[draw(5)];
    fmi3Boolean events, ended, early;
    double last;
    const fmi3Status status =
        fmi3DoStep(c, (double)now.time * QUARTER, size * QUARTER, fmi3True, &events, &ended, &early, &last);
    if (taken(status, STEP, !wrong, "step")) {
        now.time += (long)size;
        must((status == fmi3Warning) == (now.time > now.due), "a missed tick, and no other, is a warning");
        while (now.time > now.due) {
            now.due += 4;
        }
        must(fabs(last - (double)now.time * QUARTER) < 1e-6 * QUARTER, "the time after a step");
    }
}

static void tick(fmi3Clock active) {
    if (taken(fmi3SetClock(c, sample, 1, &active), EVENT | TICK, !active || now.time == now.due,
              "set a clock")) {
        now.mode = active ? TICK : EVENT;
    }
}

static void look(void) {
    fmi3Clock active;
    double u;
    const fmi3ValueReference command[] = {7};
    must(fmi3GetClock(c, sample, 1, &active) == fmi3OK && active == (now.mode == TICK), "get a clock");
    must(fmi3GetFloat64(c, command, 1, &u, 1) == fmi3OK && !(fabs(u) > 10.0),
         "the command is within its limit");
}

static void begin(void) {
    if (taken(fmi3EnterInitializationMode(c, fmi3False, 0.0, 0.0, fmi3False, 0.0), NEW, 1, "initialize")) {
        now = (belief){.mode = INITIAL};
    }
}

static void call(void) {
    double number = values[draw(9)];
    switch (draw(18)) {
    case 0:
        begin();
        break;
    case 1:
        if (taken(fmi3ExitInitializationMode(c), INITIAL, 1, "initialized")) {
            now.mode = EVENT;
        }
        break;
    case 2:
    case 3:
        if (taken(fmi3EnterEventMode(c), STEP, 1, "enter the event mode")) {
            now.mode = EVENT;
        }
        break;
    case 4:
        if (taken(fmi3EnterStepMode(c), EVENT, 1, "enter the step mode")) {
            now.mode = STEP;
        }
        break;
    case 5:
        tick(fmi3ClockInactive);
        break;
    case 6:
    case 7:
        tick(fmi3ClockActive);
        break;
    case 8:
    case 9:
        (void)taken(fmi3SetFloat64(c, velocity, 1, &number, 1), NEW | INITIAL | TICK, 1, "set an input");
        break;
    case 10:
        (void)taken(fmi3GetShiftDecimal(c, sample, 1, &number), INITIAL | EVENT | TICK, 1, "get the shift");
        break;
    case 11:
        (void)taken(fmi3SetFloat64(c, integral, 1, &number, 1), 0, 1, "set what is computed");
        break;
    case 12:
        (void)taken(fmi3SetClock(c, none, 1, (const fmi3Clock[]){fmi3ClockActive}), 0, 1, "set no clock");
        break;
    case 13:
        (void)taken(fmi3SetShiftDecimal(c, sample, 1, &number), 0, 1, "set the shift");
        break;
    case 14:
        if (taken(fmi3Terminate(c), STEP | EVENT | TICK, 1, "terminate")) {
            now.mode = ENDED;
        }
        break;
    case 15:
        if (taken(update(), EVENT | TICK, 1, "update")) {
            now.due = now.mode == TICK ? now.time + 4 : now.due;
            now.mode = EVENT;
        }
        break;
    case 16:
    default:
        step();
    }
}

static void same(double one, double other, const char *what) {
    must(one == other || (isnan(one) && isnan(other)), what);
}

/* A tick as an importer should take it. */
static void sampled(void) {
    const double number = values[draw(4)];
    const fmi3Clock active = fmi3ClockActive;
    double asked, after, between;
    must(fmi3SetClock(c, sample, 1, &active) == fmi3OK, "activate");
    must(draw(3) == 0 || fmi3SetFloat64(c, velocity, 1, &number, 1) == fmi3OK, "set in a tick");
    must(fmi3GetFloat64(c, integral, 1, &asked, 1) == fmi3OK, "ask in a tick");
    must(update() <= fmi3Warning, "take a tick");
    must(fmi3GetFloat64(c, integral, 1, &after, 1) == fmi3OK, "ask after a tick");
    must(fmi3EnterStepMode(c) == fmi3OK, "step mode");
    must(fmi3GetFloat64(c, integral, 1, &between, 1) == fmi3OK, "ask between ticks");
    same(asked, after, "a tick takes what was answered");
    same(after, between, "a tick is over");
    now.due = now.time + 4;
    now.mode = STEP;
    messages = 0;
    ticks++;
}

/* A call that is right, so that random ones come everywhere in a run. */
static void go_on(void) {
    if (now.mode == NEW) {
        begin();
    } else if (now.mode == INITIAL) {
        must(fmi3ExitInitializationMode(c) == fmi3OK, "initialized");
        now.mode = EVENT;
    } else if (now.mode == EVENT && now.time == now.due) {
        sampled();
    } else if (now.mode == EVENT) {
        must(fmi3EnterStepMode(c) == fmi3OK, "on");
        now.mode = STEP;
    } else if (now.mode == STEP && now.time == now.due) {
        must(fmi3EnterEventMode(c) == fmi3OK, "an event");
        now.mode = EVENT;
    } else if (now.mode == STEP) {
        step();
    } else if (now.mode == WRONG) {
        must(fmi3SetFMUState(c, saved) == fmi3OK, "restore after an error");
        now = kept;
    }
}

int main(void) {
    int active = 0;
    c = fmi3InstantiateCoSimulation("a", MODEL_TOKEN, NULL, fmi3False, fmi3True, fmi3False, fmi3False, NULL,
                                    0, NULL, count, NULL);
    must(c == NULL && messages == 1, "a clock needs the event mode");
    messages = 0;
    c = fmi3InstantiateCoSimulation("a", MODEL_TOKEN, NULL, fmi3False, fmi3True, fmi3True, fmi3False, NULL, 0,
                                    NULL, count, NULL);
    must(c != NULL, "instantiate");
    now.mode = NEW;
    must(fmi3GetFMUState(c, &saved) == fmi3OK, "save");
    kept = now;
    for (int k = 0; k < CALLS; k++) {
        if (draw(4) == 0) {
            call();
        } else {
            go_on();
        }
        look();
        active += now.mode == TICK;
        if (now.mode == ENDED || draw(500) == 0) {
            must(fmi3Reset(c) == fmi3OK, "reset");
            now = (belief){.mode = NEW};
        }
        if (now.mode != WRONG && draw(10) == 0) {
            must(fmi3GetFMUState(c, &saved) == fmi3OK, "save into what was saved");
            kept = now;
        }
    }
    must(fmi3FreeFMUState(c, &saved) == fmi3OK, "free a state");
    fmi3FreeInstance(c);
    must(ticks > CALLS / 20 && active > CALLS / 20, "many calls came where the clock ticked");
    printf("%d calls\n", CALLS);
    return 0;
}
