"""What the piston moves and what resists it: mechanisms, frictions and end stops, one a file."""

from hydroservo.machine.mechanics.contact import Contact
from hydroservo.machine.mechanics.elasto_plastic import ElastoPlastic
from hydroservo.machine.mechanics.lugre import LuGre, LuGreState
from hydroservo.machine.mechanics.mass import Mass
from hydroservo.machine.mechanics.mass_spring_damper import MassSpringDamper
from hydroservo.machine.mechanics.no_stops import NoStops
from hydroservo.machine.mechanics.nothing_carried import NothingCarried, NothingCarriedState
from hydroservo.machine.mechanics.one_link_arm import OneLinkArm
from hydroservo.machine.mechanics.stops import Stops
from hydroservo.machine.mechanics.stribeck import Stribeck, StribeckState
from hydroservo.machine.mechanics.swinging_load import SwingingLoad, SwingingLoadState
from hydroservo.machine.mechanics.viscous import Viscous, ViscousState

__all__ = [
    "Contact",
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
