"""The paper's numbers, once and in SI units: the machine, what is uncertain of it, demands, loads and gains.

All are those of Sec. 4 of doi:10.1007/s42401-021-00087-w but for what is called chosen, which the paper does
not give. Not all are what they seem: the return pressure and the valve's lag are listed and enter no
equation, and the switching gain D_2 is far below the disturbance that it must exceed.
"""

from hydroservo.control.controllers.backstepping import Backstepping
from hydroservo.control.controllers.pi import PI
from hydroservo.control.controllers.saturation import Saturation
from hydroservo.control.controllers.tsmc import TSMC
from hydroservo.control.error_dynamics.explicit_reaching import ExplicitReaching
from hydroservo.control.observers.boundary_layer import BoundaryLayer
from hydroservo.control.observers.filtered_derivative import FilteredDerivative
from hydroservo.control.observers.model_derivative import ModelDerivative
from hydroservo.control.observers.tsm import TSMObserver
from hydroservo.control.references.sine import Sine
from hydroservo.control.references.square import Square
from hydroservo.core.roles import Load, Reference
from hydroservo.machine.loads.constant import Constant
from hydroservo.machine.loads.sine import Sine as SineLoad
from hydroservo.machine.plants.design_model import DesignModel
from hydroservo.machine.plants.load_pressure import LoadPressurePlant
from hydroservo.machine.supplies.ideal import IdealSupply
from hydroservo.machine.valves.orifice import Orifice
from hydroservo.machine.valves.static import StaticValve

SOURCE = "doi:10.1007/s42401-021-00087-w, Sec. 4"

PLANT = LoadPressurePlant(
    mass=6.0,  # m [kg]
    damping=50.0,  # b [N s/m]
    piston_area=4.91e-4,  # A_p [m^2]
    total_volume=8.74e-5,  # V_t [m^3]; the paper calls it half, its equations take it as the whole
    bulk_modulus=7.0e8,  # beta_e [Pa]
    leakage=2.5e-11,  # C_tl [m^3/(s Pa)]
    stroke=0.078,  # L_max [m]
    start_position=0.039,  # [m] mid-stroke, chosen
)
ORIFICE = Orifice(
    discharge_coefficient=0.62,  # C_d
    area_gradient=0.024,  # w [m]
    density=850.0,  # rho [kg/m^3]
)
VALVE = StaticValve(
    gain=5e-4,  # K_sv [m/V]
    max_opening=5e-3,  # x_max [m]
    orifice=ORIFICE,
)
SUPPLY = IdealSupply(
    supply_pressure=40e5,  # p_s [Pa]
    return_pressure=0.0,  # [Pa] p_r = 2 bar is listed and enters no equation
)
VALVE_LAG = 0.01  # T_sv [s]; enters no equation

UNCERTAINTY = {  # Delta, relative
    "plant.damping": 0.20,
    "plant.bulk_modulus": 0.10,
    "plant.leakage": 0.30,
    "valve.orifice.discharge_coefficient": 0.10,
    "valve.orifice.area_gradient": 0.10,
    "valve.orifice.density": 0.15,
}

DURATION = 8.0  # [s]
AMPLITUDE = 0.03  # [m/s] of both demands
PERIOD = 4.0  # [s] of the sine; of the square chosen
LOAD = 100.0  # [N] of both loads
REFERENCES: dict[str, Reference] = {
    "sine": Sine(AMPLITUDE, 1.0 / PERIOD),
    "square": Square(AMPLITUDE, PERIOD),
}
LOADS: dict[str, Load] = {"sine": SineLoad(LOAD, 1.0 / PERIOD), "square": Constant(LOAD)}

COMMAND_LIMIT = Saturation(10.0)  # [V] x_max/K_sv
MODEL = DesignModel(PLANT, ORIFICE, SUPPLY, VALVE.gain)

PROPORTIONAL_INTEGRAL = PI(
    proportional_gain=100.0,  # k_p [V s/m]
    integral_gain=10.0,  # k_i [V/m]
    anti_windup=0.0,  # none
    saturation=COMMAND_LIMIT,
)
BACKSTEPPING = Backstepping(
    velocity_gain=2000.0,  # k_1 [1/s]
    force_gain=1000.0,  # k_2 [1/s]
    model=MODEL,
    derivative=ModelDerivative(),
    saturation=COMMAND_LIMIT,
)
OBSERVER = TSMObserver(
    linear_gain_1=1000.0,  # k_d1 [1/s]
    linear_gain_2=1000.0,  # k_d2 [1/s]
    switching_gain_1=30.0,  # D_1 [m/s^2]
    switching_gain_2=100.0,  # D_2 [N/s]
    power_gain_1=100.0,  # epsilon_1 [(m/s)^(2/7)/s]
    power_gain_2=10.0,  # epsilon_2 [N^(2/7)/s]
    exponent=5 / 7,  # p_0/q_0 and p_1/q_1
    realisation=BoundaryLayer(1e-3, 1e-3),  # [m/s], [N] chosen
)
TERMINAL = TSMC(
    linear_gain_1=1e4,  # mu_1 [1/s]
    linear_gain_2=100.0,  # mu_2 [1/s]
    power_gain_1=1.0,  # delta_1 [(m/s)^(2/7)/s]
    power_gain_2=1.0,  # delta_2 [(m/s^2)^(4/9)/s]
    exponent_1=5 / 7,  # p_1/q_1
    exponent_2=5 / 9,  # p_2/q_2
    model=MODEL,
    observer=OBSERVER,
    derivative=FilteredDerivative(1e-3),  # [s] chosen
    saturation=COMMAND_LIMIT,
    reaching=ExplicitReaching(1e-4),  # [m/s] chosen
)
