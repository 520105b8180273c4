"""The generator of random programs: seeded, and accepted by LinuxCNC."""

import random

import pytest

from .generator import KEYWORDS, KINDS, random_program
from .oracle import ProgramError, available, motions_of_many

MANY = 20


def some_programs(kind):
    return [random_program(random.Random(f"{kind} {i}"), kind) for i in range(MANY)]


@pytest.mark.parametrize("kind", KINDS)
def test_a_seed_gives_one_program(kind):
    programs = some_programs(kind)
    assert programs == some_programs(kind)
    assert len(set(programs)) == MANY
    assert all(20 <= program.count("\n") <= 70 for program in programs)


@pytest.mark.skipif(available() is not None, reason=str(available()))
@pytest.mark.parametrize("kind", KINDS)
def test_nine_in_ten_are_accepted_and_move(kind):
    programs = some_programs(kind)
    results = motions_of_many([(program, KEYWORDS) for program in programs])
    refused = {
        i: str(result) for i, result in enumerate(results) if isinstance(result, ProgramError)
    }
    assert len(refused) <= MANY // 10, refused
    assert all(result for result in results if not isinstance(result, ProgramError))
