"""Controllers that between them hold every law, observer and part of the project."""

from collections.abc import Iterator

from hydroservo.control.controllers import (
    DAC,
    PI,
    PID,
    TSMC,
    AccelerationFeedback,
    AntiWindup,
    Backstepping,
    Cascade,
    CharacteristicCompensation,
    DeadBandCompensation,
    DeadBandJump,
    Delay,
    DirectionalGain,
    FlowCompensation,
    InvertedPolarity,
    PressureFeedback,
    RateLimit,
    Saturation,
    ValveInversion,
    VelocityCompensation,
)
from hydroservo.control.error_dynamics import ExplicitReaching, ImplicitReaching, SmoothReaching
from hydroservo.control.observers import (
    BoundaryLayer,
    Explicit,
    FilteredDerivative,
    Implicit,
    KalmanObserver,
    ModelDerivative,
    PositionKalmanObserver,
    TSMObserver,
)
from hydroservo.core.block import Block, is_block
from hydroservo.core.roles import (
    Basis,
    Controller,
    Differentiator,
    ErrorDynamics,
    Observer,
    Reaching,
    Realisation,
)
from hydroservo.papers.tsmc_eha_2021.printed import PrintedBackstepping, PrintedTSMC
from hydroservo.scenario.registry import shipped_classes
from hydroservo.scenario.role_checks import declared_roles
from hydroservo.testing.examples import example
from hydroservo.testing.loops import loop_with

PARTS = (
    Controller,
    Observer,
    Realisation,
    Reaching,
    ErrorDynamics,
    Differentiator,
    Basis,
)  # roles on the target

CHOSEN: dict[str, Controller] = {
    "PI": example(PI, anti_windup=50.0),
    "backstepping": example(Backstepping, derivative=ModelDerivative()),
    "backstepping filtered": example(Backstepping, derivative=FilteredDerivative()),
    "backstepping as printed": PrintedBackstepping(),
    "TSMC": example(
        TSMC, observer=example(TSMObserver, realisation=BoundaryLayer()), reaching=ExplicitReaching()
    ),
    "TSMC explicit": example(
        TSMC, observer=example(TSMObserver, realisation=Explicit()), reaching=SmoothReaching()
    ),
    "TSMC implicit": example(
        TSMC, observer=example(TSMObserver, realisation=Implicit()), reaching=ImplicitReaching()
    ),
    "TSMC as printed": PrintedTSMC(),
    "TSMC Kalman": example(TSMC, observer=example(KalmanObserver)),
    "TSMC position Kalman": example(
        TSMC, observer=example(PositionKalmanObserver), reaching=ImplicitReaching()
    ),
    "anti-windup": example(AntiWindup, controller=example(PI, saturation=Saturation(1000.0))),
    "DAC": DAC(controller=example(PI)),
    "delay": Delay(controller=Delay(controller=example(PI))),
    "rate limit": example(RateLimit, controller=example(Backstepping)),
    "valve inversion": example(ValveInversion, controller=example(TSMC)),
    "PID": example(PID, anti_windup=50.0),
    "cascade": example(Cascade, example(AccelerationFeedback)),
    "force with velocity compensation": example(VelocityCompensation, example(DeadBandJump)),
    "inverted polarity": InvertedPolarity(example(PI)),
    "characteristic": example(CharacteristicCompensation, example(PID)),
    "industrial axis": example(
        DeadBandCompensation,
        example(FlowCompensation, example(DirectionalGain, example(PressureFeedback, example(PID)))),
    ),
    "DAC around rate limit around valve inversion": DAC(
        example(RateLimit, example(ValveInversion, example(TSMC)))
    ),
}


def types_in(block: Block) -> Iterator[type]:
    """The class of a block and of all that is in it."""
    yield type(block)
    for value in block:
        if is_block(value):
            yield from types_in(value)


def others() -> Iterator[tuple[str, Controller]]:
    """A law for each block of these roles that no chosen one has, by the block's name."""
    chosen = {cls for law in CHOSEN.values() for cls in types_in(law)}
    for cls in shipped_classes():
        for role in PARTS:
            if role in declared_roles(cls) and cls not in chosen:
                loop = loop_with(example(cls), role)
                if loop is not None:
                    yield cls.__name__, loop.controller


LAWS = CHOSEN | dict(others())
