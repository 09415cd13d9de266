/* Co-simulation: what a communication step does. An FMU has it from steps.c, where a step takes whole samples, or from
   ticks.c, where a step lets time pass and a clock takes them. */
#ifndef STEPS_H
#define STEPS_H

#include "instance.h"

#define steps_take FMU_NAME(steps_take)

status steps_take(instance *self, double point, double size);

#endif
