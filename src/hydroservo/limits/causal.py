"""The best commands where jumps of the demand and of the load are known only once they are there."""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np

from hydroservo.limits.command import CommandLimits
from hydroservo.limits.foreknown import Foreknown, expected, jumps
from hydroservo.limits.interval import Interval
from hydroservo.limits.problem import Course, Optimum, optimum

TAIL = 0.1  # of a stretch between jumps: how much longer it is expected to last
LEAST_TAIL = 20  # samples

Solved = Callable[[int], None]  # called with the samples that are done


def surprises(known: Foreknown, limits: CommandLimits, samples: int) -> list[int]:
    """The samples whose commands are the first to tell of a jump, 0 and the end among them."""
    steps = np.unique(np.concatenate(jumps(known)))
    found = {math.ceil(int(step) / known.substeps) + limits.late for step in steps}
    return sorted({0, *(k for k in found if k < samples), samples})


def causal_course(
    one: Interval, limits: CommandLimits, known: Foreknown, guess: Course, threads: int, done: Solved
) -> Iterator[Optimum]:
    """The commands of a controller that knows all but the jumps to come, a stretch between two at a time.

    From the state in which a jump finds the machine, the commands are those that would leave the least
    squared error if the demand went on at its rate, and the load stayed, for a tenth longer than they do.

    Args:
        one: a sample period of the machine.
        limits: of the command.
        known: the demand and the load as they will be.
        guess: a course of the whole run, where searches begin.
        threads: on which samples are computed.
        done: told how many samples are done.

    Yields:
        The optimum of each stretch, cut where the next jump is known.
    """
    samples = guess.commands.size
    state = guess.states[:, 0]
    for first, last in pairwise(surprises(known, limits, samples)):
        tail = max(math.ceil(TAIL * (last - first)), LEAST_TAIL)
        end = min(last + tail, samples)
        told = max(first - limits.late, 0) * known.substeps
        begin = guess.part(first, end)
        begin = begin._replace(states=np.column_stack([state, begin.states[:, 1:]]))
        seen = expected(known, told + 1)
        found = optimum(one, limits, seen.table(first, end), begin, threads)
        state = found.course.states[:, last - first].copy()
        done(last)
        yield found._replace(course=found.course.part(0, last - first))
