"""Cost against the number of runs and against the number of steps, as a picture."""

from pathlib import Path

from hydroservo.figures.style import PALETTE, figure, style

__all__ = ["PICTURE", "draw"]

PICTURE = Path(__file__).parents[1] / "docs" / "_static" / "speed.png"
HEIGHT = 2.9  # inch

Points = list[tuple[int, float]]


def draw(measured: dict[str, dict[str, Points]], path: Path = PICTURE) -> None:
    """Saves the picture; a contender has the same colour on both sides."""
    names = list(measured["runs"])
    with style():
        fig = figure(HEIGHT)
        many, one = fig.subplots(1, 2)
        for name, colour in zip(names, PALETTE, strict=False):
            wide = 2.0 if name == names[0] else 1.1
            runs, cost = zip(*measured["runs"][name], strict=True)
            many.plot(
                runs,
                [1e9 * seconds for seconds in cost],
                "o-",
                color=colour,
                linewidth=wide,
                markersize=3,
                label=name,
            )
            if measured["steps"][name]:
                steps, total = zip(*measured["steps"][name], strict=True)
                one.plot(steps, total, "o-", color=colour, linewidth=wide, markersize=3)
        many.set(
            xscale="log", yscale="log", xlabel="runs, on one core", ylabel="time of a sample period [ns]"
        )
        one.set(xscale="log", yscale="log", xlabel="sample periods of one run", ylabel="time [s]")
        for axis in (many, one):
            axis.margins(x=0.05)
        fig.legend(loc="outside upper center", ncols=len(names))
        fig.savefig(path, metadata={"Software": None})
