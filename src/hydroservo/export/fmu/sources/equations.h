/* Model exchange: an importer integrates the model. */
#ifndef EQUATIONS_H
#define EQUATIONS_H

#include "instance.h"

#define equations_set_time FMU_NAME(equations_set_time)
#define equations_enter_events FMU_NAME(equations_enter_events)
#define equations_update FMU_NAME(equations_update)
#define equations_enter_continuous FMU_NAME(equations_enter_continuous)
#define equations_set_states FMU_NAME(equations_set_states)
#define equations_get_states FMU_NAME(equations_get_states)
#define equations_get_rates FMU_NAME(equations_get_rates)
#define equations_get_nominals FMU_NAME(equations_get_nominals)

status equations_set_time(instance *self, double time);

/* From here on a jump at this instant counts. */
status equations_enter_events(instance *self);

/* Finds the time of the next jump; inf if there is none. */
status equations_update(instance *self, double *next);

/* From here on nothing is seen of the next jump. */
status equations_enter_continuous(instance *self);

/* A state that is no number is discarded, and none of them changes. */
status equations_set_states(instance *self, const double values[], size_t count);
status equations_get_states(instance *self, double values[], size_t count);

/* Rates that are not finite are discarded, so that an importer takes a smaller step. */
status equations_get_rates(instance *self, double values[], size_t count);
status equations_get_nominals(instance *self, double values[], size_t count);

#endif
