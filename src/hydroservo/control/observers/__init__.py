"""Disturbance observers and derivative estimates, with their realisations of sgn."""

from hydroservo.control.observers.adaptive_tsm import AdaptiveTSMObserver, AdaptiveTSMObserverState
from hydroservo.control.observers.boundary_layer import BoundaryLayer
from hydroservo.control.observers.estimates import Estimates
from hydroservo.control.observers.explicit import Explicit
from hydroservo.control.observers.extended_state import ExtendedStateObserver
from hydroservo.control.observers.filtered_derivative import FilteredDerivative, FilteredDerivativeState
from hydroservo.control.observers.high_gain import HighGainObserver
from hydroservo.control.observers.implicit import Implicit
from hydroservo.control.observers.kalman import KalmanObserver
from hydroservo.control.observers.model_derivative import ModelDerivative, ModelDerivativeState
from hydroservo.control.observers.no_observer import NoObserver, NoObserverState
from hydroservo.control.observers.position_kalman import PositionKalmanObserver, PositionKalmanObserverState
from hydroservo.control.observers.tsm import TSMObserver, TSMObserverState
from hydroservo.control.observers.valve_lag import ValveLag, ValveLagState

__all__ = [
    "AdaptiveTSMObserver",
    "AdaptiveTSMObserverState",
    "BoundaryLayer",
    "Estimates",
    "Explicit",
    "ExtendedStateObserver",
    "FilteredDerivative",
    "FilteredDerivativeState",
    "HighGainObserver",
    "Implicit",
    "KalmanObserver",
    "ModelDerivative",
    "ModelDerivativeState",
    "NoObserver",
    "NoObserverState",
    "PositionKalmanObserver",
    "PositionKalmanObserverState",
    "TSMObserver",
    "TSMObserverState",
    "ValveLag",
    "ValveLagState",
]
