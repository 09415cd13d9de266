"""Disturbance observers and derivative estimates, with their realisations of sgn."""

from hydroservo.observers.adaptive_tsm import AdaptiveTSMObserver, AdaptiveTSMObserverState
from hydroservo.observers.boundary_layer import BoundaryLayer
from hydroservo.observers.estimates import Estimates
from hydroservo.observers.explicit import Explicit
from hydroservo.observers.extended_state import ExtendedStateObserver
from hydroservo.observers.filtered_derivative import FilteredDerivative, FilteredDerivativeState
from hydroservo.observers.high_gain import HighGainObserver
from hydroservo.observers.implicit import Implicit
from hydroservo.observers.kalman import KalmanObserver
from hydroservo.observers.model_derivative import ModelDerivative, ModelDerivativeState
from hydroservo.observers.no_observer import NoObserver, NoObserverState
from hydroservo.observers.position_kalman import PositionKalmanObserver, PositionKalmanObserverState
from hydroservo.observers.tsm import TSMObserver, TSMObserverState
from hydroservo.observers.valve_lag import ValveLag, ValveLagState

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
