"""What the piston moves and what resists it: mechanisms, frictions and end stops, one a file."""

from hydroservo.mechanics.elasto_plastic import ElastoPlastic
from hydroservo.mechanics.lugre import LuGre, LuGreState
from hydroservo.mechanics.mass import Mass
from hydroservo.mechanics.mass_spring_damper import MassSpringDamper
from hydroservo.mechanics.no_stops import NoStops
from hydroservo.mechanics.nothing_carried import NothingCarried, NothingCarriedState
from hydroservo.mechanics.one_link_arm import OneLinkArm
from hydroservo.mechanics.stops import Stops
from hydroservo.mechanics.stribeck import Stribeck, StribeckState
from hydroservo.mechanics.swinging_load import SwingingLoad, SwingingLoadState
from hydroservo.mechanics.viscous import Viscous, ViscousState

__all__ = [
    "ElastoPlastic",
    "LuGre",
    "LuGreState",
    "Mass",
    "MassSpringDamper",
    "NoStops",
    "NothingCarried",
    "NothingCarriedState",
    "OneLinkArm",
    "Stops",
    "Stribeck",
    "StribeckState",
    "SwingingLoad",
    "SwingingLoadState",
    "Viscous",
    "ViscousState",
]
