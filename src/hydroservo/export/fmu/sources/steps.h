/* Co-simulation: an instance takes whole samples. */
#ifndef STEPS_H
#define STEPS_H

#include "instance.h"

#define steps_take FMU_NAME(steps_take)

/* Takes all samples of a communication step, with the inputs held. */
status steps_take(instance *self, double point, double size);

#endif
