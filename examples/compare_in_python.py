"""Two controllers on one machine, under equal conditions, from Python."""

import hydroservo as hs


def main() -> None:
    """Print the tracking error of PI and of TSMC over the stiffness of the oil."""
    coarser = {"simulation.period": "100 us", "simulation.substeps": 10}
    machine = hs.load_scenario("paper/square-pi", coarser)
    calm = {"observer.realisation": hs.observers.Implicit(), "observer.switching_gain_2": 1e5}
    knowing = {"model": hs.plants.ThisMachine()}  # believes in the machine of its loop
    tsmc = hs.replace(hs.load_scenario("paper/square-tsmc").controller, calm | knowing)
    controllers = {"PI": machine.controller, "TSMC": tsmc}
    print(f"{'bulk modulus':>12}  {'controller':<10}  {'rms error':>12}  {'total variation':>15}")
    for bulk_modulus in (5e8, 7e8, 9e8):
        for name, controller in controllers.items():
            loop = hs.replace(machine, {"plant.bulk_modulus": bulk_modulus, "controller": controller})
            data = hs.simulate(loop, record=())
            error, effort = float(data["rms_error"]), float(data["control_total_variation"])
            found = f"{1e3 * error:7.4f} mm/s  {effort:13.2f} V" if not data["diverged"] else "diverged"
            print(f"{bulk_modulus / 1e5:8.0f} bar  {name:<10}  {found}")


if __name__ == "__main__":
    main()
