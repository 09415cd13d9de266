"""The contract of a block: what hydroservo asks of its own blocks, to be asked of any.

With pytest, a test for each question::

    from hydroservo.testing import BlockContract

    class TestMyController(BlockContract):
        block = MyController()

Without it, :func:`check_block` raises at the first thing that is not as it must be, and :func:`answers` gives
an answer to each question. On the command line, ``hydroservo check my_controller.py``. Random parameters and
inputs are drawn by hypothesis: ``pip install 'hydroservo[testing]'``.
"""

from hydroservo.testing.case import ContractError
from hydroservo.testing.contract import Answer, BlockContract, answers, check_block

__all__ = ["Answer", "BlockContract", "ContractError", "answers", "check_block"]
