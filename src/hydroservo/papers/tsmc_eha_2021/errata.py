"""Where the print cannot be meant as it stands, what is meant, and what each reading does here."""

from typing import NamedTuple


class Erratum(NamedTuple):
    """One difference between the print and what is simulated."""

    equations: str
    printed: str
    meant: str
    why: str
    here: str


ERRATA = (
    Erratum(
        "(5), (7), (26)",
        "leakage term 4 beta_e A_p C_tl/V_t x2",
        "4 beta_e C_tl/V_t x2",
        "x2 is A_p p_L already; as printed the units do not match and the damping all but vanishes",
        "printed.printed_leakage takes the printed term",
    ),
    Erratum(
        "(7)",
        "d_L2 = Delta f2 + Delta g2",
        "d_L2 = Delta f2 + Delta g2 u",
        "Delta g2 alone has another unit than f2",
        "disturbances are computed as the machine's true rates less the nominal model's",
    ),
    Erratum(
        "(2), (5)",
        "the supply pressure p_s alone",
        "p_s - p_r where a return pressure is given",
        "p_r = 2 bar is listed and appears in no equation",
        "supply.return_pressure, 0 in the built-in scenarios: pressures are above the return line's",
    ),
    Erratum(
        "(3)",
        "V_t is called the half-volume",
        "V_t is the total volume",
        "the factor 4 beta_e belongs to the total volume of both chambers",
        "plant.total_volume",
    ),
    Erratum(
        "(9)",
        "t_f - t_0 <= ln(...)/(mu (1 + alpha))",
        "t_f - t_0 <= ln(...)/(mu (1 - alpha))",
        "integrate (8) with W = V^(1 - alpha); the printed bound is too short",
        "hydroservo.machine.theory.settling_bound, and printed.printed_settling_bound for the printed form",
    ),
    Erratum(
        "(13), (19)",
        "p1/q1 is the exponent of the observer's second channel and that of xi1",
        "two exponents that happen to be equal, both 5/7",
        "the observer's are p0/q0 and p1/q1, both 5/7; the controller's are p1/q1 and p2/q2",
        "observer.exponent serves both channels; controller.exponent_1 and exponent_2 are the law's own",
    ),
    Erratum(
        "(16), (17)",
        "exponents p + q/q",
        "(p + q)/q",
        "brackets are missing; and (17) bounds k s^2 by k V where it is 2 k V, weaker but true",
        "condition_17 of the paper's lemmas takes 2 k V; half the linear gain gives the printed form",
    ),
    Erratum(
        "(18)",
        "the estimation errors converge to zero",
        "their averages do",
        "with sgn the estimate itself switches by +-D for ever; only its Filippov average converges",
        "three realisations of sgn; the implicit one returns the average over a sample period",
    ),
    Erratum(
        "(21), (22)",
        "the second derivative of y_d, in the text as it reached us",
        "the third derivative of y_d",
        "differentiating (20) once more raises the order",
        "references give the demand with two derivatives; PrintedTSMC puts the first into (22)",
    ),
    Erratum(
        "(22)",
        "d(s1^(p1/q1))/dt",
        "d(xi1^(p1/q1))/dt",
        "(21), from which (22) follows, has xi1",
        "PrintedTSMC differentiates s1^(p1/q1) numerically",
    ),
    Erratum(
        "(22)",
        "the derivative of xi1^(p1/q1), singular at xi1 = 0",
        "regularised",
        "its exponent p1/q1 - 1 is negative",
        "(|xi1| + controller.reaching.least_surface)^(p1/q1 - 1)",
    ),
    Erratum(
        "(22)",
        "the estimate of d_L1 undifferentiated in one place, in the text as it reached us",
        "its time derivative",
        "(21) has the derivative, which contains that of a sgn and must be estimated",
        "controller.derivative, a filtered difference; PrintedTSMC leaves the estimate as it is",
    ),
    Erratum(
        "(26)",
        "f1 = +b x1/m, z1 = x1 - y_d, xi_1 and zeta_1 for one thing, sgn(eta u) with eta undefined",
        "f1 = -b x1/m, z1 = x1 - dy_d/dt, zeta_1 is the virtual control",
        "(7) has -b x1/m, and the demand is a velocity",
        "PrintedBackstepping takes the letter: the velocity then follows a position demand",
    ),
    Erratum(
        "Lemma 2",
        "D_2 = 100 N/s satisfies D_2 > sup |d_L2|",
        "it does not, by orders of magnitude; D_1 does",
        "at +Delta the simulated disturbance is far larger; the report lists the margin of each run",
        "the gains stay as printed; observer.switching_gain_2 changes them",
    ),
    Erratum(
        "Assumption 2",
        "|y_d| <= Y_0 < k_c1",
        "|y_d| <= Y_0",
        "k_c1 is defined nowhere and used nowhere else",
        "nothing here needs it",
    ),
    Erratum(
        "(1)",
        "a static valve",
        "a lag of T_sv = 10 ms, if the list of parameters is believed",
        "T_sv is listed and unused; with it the printed PI is unstable",
        "valve.type = FirstOrderValve",
    ),
    Erratum(
        "Sec. 4",
        "a square demand of +-30 mm/s on a stroke of 78 mm",
        "possible only from near the lower end of the stroke",
        "with the sine's period it moves 60 mm to one side; from mid-stroke there are 39 mm",
        "it starts at mid-stroke (plant.start_position) and leaves the stroke, which is reported",
    ),
)
