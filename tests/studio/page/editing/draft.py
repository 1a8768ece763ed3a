"""The scene that the tests of editing begin with."""

from scenes import Region, Scene

DT = 0.2


def scene() -> Scene:
    return Scene(
        name="draft",
        title="A draft",
        robot="linear",
        formula="F_[0:10](A1) &  G_[0:20]( !B )",
        horizon=20,
        seed=1,
        regions=(
            Region("A1", "circle", (1, 2), (0.5,)),
            Region("B", "rectangle", (0, 0), (1, 0.5), "#123456"),
            Region("C", "circle", (3, 3), (0.2,)),
        ),
        initial=Region("initial", "rectangle", (-3, -3), (0.5, 0.5)),
    )
