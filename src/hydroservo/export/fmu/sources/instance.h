/* One instance of the model, for both versions of FMI: its life, its variables and its saved states.

   fmi2.c and fmi3.c translate between this and the functions of their version; steps.h is co-simulation,
   ticks.h its clock, and equations.h model exchange. Nothing here is global, and nothing but saved states is
   allocated. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include "model.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Several FMUs may be linked into one program, so the names of functions tell whose they are. */
#define instance_begin FMU_NAME(instance_begin)
#define instance_log FMU_NAME(instance_log)
#define instance_warn FMU_NAME(instance_warn)
#define instance_refuse FMU_NAME(instance_refuse)
#define instance_discard FMU_NAME(instance_discard)
#define instance_allows FMU_NAME(instance_allows)
#define instance_lacks FMU_NAME(instance_lacks)
#define instance_setup FMU_NAME(instance_setup)
#define instance_enter_initialization FMU_NAME(instance_enter_initialization)
#define instance_exit_initialization FMU_NAME(instance_exit_initialization)
#define instance_terminate FMU_NAME(instance_terminate)
#define instance_reset FMU_NAME(instance_reset)
#define instance_get FMU_NAME(instance_get)
#define instance_set FMU_NAME(instance_set)
#define instance_number FMU_NAME(instance_number)
#define instance_numbers FMU_NAME(instance_numbers)
#define instance_time FMU_NAME(instance_time)
#define instance_save FMU_NAME(instance_save)
#define instance_restore FMU_NAME(instance_restore)
#define instance_free_saved FMU_NAME(instance_free_saved)
#define instance_saved_size FMU_NAME(instance_saved_size)
#define instance_serialize FMU_NAME(instance_serialize)
#define instance_deserialize FMU_NAME(instance_deserialize)

/* What a call reports, numbered as in both versions of FMI. */
typedef enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR } status;

/* Where in its life an instance is; one bit each, so that calls can name several. */
typedef enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEPPING = 4,
    TERMINATED = 8,
    FAILED = 16, /* after an error, as FMI wants it: only reading, restoring, resetting and freeing go on */
    EVENTS = 32,
    CONTINUOUS = 64, /* an importer integrates */
    TICKING = 128,   /* in the event mode, with an active clock */
    LAST_PHASE = TICKING
} phase;

#define RUNNING (STEPPING | EVENTS | CONTINUOUS | TICKING)

/* All that a saved state holds. */
typedef struct {
    char token[40]; /* of the FMU that it belongs to */
    uint64_t phase;
    uint64_t samples; /* taken since the start */
    double start;     /* [s] time of the start */
    double stop;      /* [s] time that must not be passed */
    double time;      /* [s] of model exchange, and of an FMU with a clock */
    double jump;      /* [s] of model exchange: when what drives the model jumps next, inf if never */
    double due;       /* [s] of an FMU with a clock: when it ticks next */
    uint64_t given;   /* 1 where an input was set after the last step; in model exchange always */
    model_numbers numbers;
} snapshot;

typedef struct instance instance;

/* Hands a message to the importer. It has no character with a meaning to printf. */
typedef void message_sink(const instance *self, status severity, const char *category, const char *message);

struct instance {
    snapshot now;
    model_numbers ahead; /* where it is known, what the model makes of the inputs that are set */
    bool ahead_known;
    message_sink *sink;
    bool wanted[STATUS_ERROR + 1]; /* messages of which severity */
};

void instance_begin(instance *self, message_sink *sink);

/* Chooses the messages; a category that is not known changes nothing and gives STATUS_WARNING. */
status instance_log(instance *self, bool on, size_t count, const char *const categories[]);

/* Logs what goes on all the same; returns STATUS_WARNING. */
status instance_warn(instance *self, const char *format, ...);

/* Logs an error and leaves the instance FAILED; returns STATUS_ERROR. */
status instance_refuse(instance *self, const char *format, ...);

/* Logs that a request has no answer, or that a value is not taken; returns STATUS_DISCARD. */
status instance_discard(instance *self, const char *format, ...);

/* False, with a message, for a call that must not come in this phase; false where there is no instance. */
bool instance_allows(instance *self, unsigned phases, const char *call);

/* What a call reports that must come in one of these phases. */
#define WITHIN(self, phases, call, done) (instance_allows(self, phases, call) ? (done) : STATUS_ERROR)

/* Refuses to get or set variables of a type that no variable has. */
status instance_lacks(instance *self, size_t count, const char *type);

status instance_setup(instance *self, double start, bool stop_defined, double stop);
status instance_enter_initialization(instance *self);
status instance_exit_initialization(instance *self);
status instance_terminate(instance *self);
void instance_reset(instance *self);

/* The numbers as an importer sees them. Those of a controller follow its inputs at once, from the
   initialization on until a step takes the sample, or where it has a clock, while that is active. Those of
   equations follow whatever is set. */
const model_numbers *instance_numbers(instance *self);
double instance_number(const model_numbers *numbers, const model_variable *variable);

status instance_get(instance *self, const unsigned references[], size_t count, double values[]);
status instance_set(instance *self, const unsigned references[], size_t count, const double values[]);
double instance_time(const instance *self);

status instance_save(instance *self, void **saved);
status instance_restore(instance *self, const void *saved);
void instance_free_saved(void **saved);
status instance_saved_size(instance *self, size_t *size);
status instance_serialize(instance *self, const void *saved, void *bytes, size_t size);
status instance_deserialize(instance *self, const void *bytes, size_t size, void **saved);

#endif
