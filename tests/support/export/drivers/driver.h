/* What programs that call an FMU begin with: FMI's functions, and a count of the messages of instances. */
#ifndef DRIVER_H
#define DRIVER_H

#include "model.h" /* first: it names the prefix of FMI's functions */

#ifdef FMI2_FUNCTION_PREFIX
#include "fmi2Functions.h"
#else
#include "fmi3Functions.h"
#endif

static int messages;

#ifdef FMI2_FUNCTION_PREFIX
static void count(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                  fmi2String category, fmi2String message, ...) {
    (void)environment, (void)name, (void)status, (void)category, (void)message;
    messages++;
}
#else
static void count(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                  fmi3String message) {
    (void)environment, (void)status, (void)category, (void)message;
    messages++;
}
#endif

#endif
