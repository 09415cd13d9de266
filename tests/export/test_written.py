"""Functions whose C is written, not translated."""

import pytest

from hydroservo.core import states
from hydroservo.core.ops import random
from hydroservo.export.c.primitives import NUMBERS, WRITTEN
from hydroservo.language.program import Program
from hydroservo.language.scope import TranslationError
from hydroservo.language.terms import INT, REAL


@pytest.mark.parametrize("origin", NUMBERS, ids=lambda origin: origin.__name__)
def test_a_function_of_numbers_is_one_whatever_it_is_called_with(origin):
    translator = Program(WRITTEN, "unit")
    made = translator.function(origin, [REAL] * len(NUMBERS[origin].parameters))
    assert translator.function(origin, [INT] * len(made.parameters)) is made


def test_arithmetic_on_states_is_not_for_numbers():
    with pytest.raises(TranslationError, match="takes whole states, not numbers"):
        Program(WRITTEN, "unit").function(states.axpy, [REAL, REAL, REAL])


def test_the_kind_of_a_random_number_is_part_of_the_code():
    with pytest.raises(TranslationError, match="part of the code"):
        Program(WRITTEN, "unit").function(random.drawn, [REAL, REAL, REAL, REAL])
