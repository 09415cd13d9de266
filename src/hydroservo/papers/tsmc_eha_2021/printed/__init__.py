"""What the paper prints and cannot mean, followed to the letter."""

from hydroservo.papers.tsmc_eha_2021.printed.backstepping import PrintedBackstepping, PrintedBacksteppingState
from hydroservo.papers.tsmc_eha_2021.printed.loops import (
    printed,
    printed_law,
    printed_leakage,
    printed_settling_bound,
)
from hydroservo.papers.tsmc_eha_2021.printed.tsmc import PrintedTSMC

__all__ = [
    "PrintedBackstepping",
    "PrintedBacksteppingState",
    "PrintedTSMC",
    "printed",
    "printed_law",
    "printed_leakage",
    "printed_settling_bound",
]
