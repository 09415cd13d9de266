/* What the files of FMI 3.0 share. */
#ifndef FMI3_COMMON_H
#define FMI3_COMMON_H

#include "instance.h" /* first: it names the prefix of FMI's functions */

#include "fmi3Functions.h"

#define fmi3_begin FMU_NAME(fmi3_begin)
#define fmi3_refuse FMU_NAME(fmi3_refuse)

/* What every way to make an instance is given. */
typedef struct {
    fmi3String name;
    fmi3String token;
    fmi3Boolean logging;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} beginning;

/* Makes an instance. Where there is an objection, or the name or the token is wrong, it logs that and returns
   NULL. */
fmi3Instance fmi3_begin(const beginning *given, const char *objection);

/* Logs the reason as an error and leaves the instance FAILED; returns fmi3Error. */
fmi3Status fmi3_refuse(fmi3Instance c, const char *reason);

#endif
