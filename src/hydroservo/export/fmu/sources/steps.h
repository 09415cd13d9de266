/* Co-simulation: what a communication step does. It is in steps.c for an FMU whose steps take whole samples,
   and in ticks.c for one whose steps let time pass and whose clock takes the samples. */
#ifndef STEPS_H
#define STEPS_H

#include "instance.h"

#define steps_take FMU_NAME(steps_take)

status steps_take(instance *self, double point, double size);

#endif
