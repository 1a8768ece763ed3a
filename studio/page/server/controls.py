"""Which values a browser may give a control: of its type, within its bounds or among its options.

The viewer library casts what arrives: an integer control would hold `int(1e30)`, which no message
can carry, and every later page load would fail.
"""

from functools import singledispatch

import viser

from studio.page.server.messages import Value

LARGEST_NUMBER = 1e9
"""Of a control without bounds of its own."""
BRIGHTEST = 255


@singledispatch
def accepts(control: object, value: Value) -> bool:
    """Whether a browser may set a control to a value; no, for types that the page does not use."""
    del control, value
    return False


@accepts.register(viser.GuiCheckboxHandle)
@accepts.register(viser.GuiButtonHandle)
def _(control: object, value: Value) -> bool:
    del control
    return isinstance(value, bool)


@accepts.register
def _(control: viser.GuiTextHandle, value: Value) -> bool:
    del control
    return isinstance(value, str)


@accepts.register(viser.GuiDropdownHandle)
@accepts.register(viser.GuiButtonGroupHandle)
def _(control: viser.GuiDropdownHandle, value: Value) -> bool:
    return isinstance(value, str) and value in control.options


@accepts.register(viser.GuiNumberHandle)
@accepts.register(viser.GuiSliderHandle)
def _(control: viser.GuiNumberHandle, value: Value) -> bool:
    if not isinstance(value, float) or not _fits(value, control.min, control.max):
        return False
    return isinstance(control.value, float) or value.is_integer()


@accepts.register
def _(control: viser.GuiRgbHandle, value: Value) -> bool:
    del control
    return (
        isinstance(value, list) and len(value) == 3 and all(_fits(x, 0, BRIGHTEST) for x in value)
    )


@accepts.register(viser.GuiVector2Handle)
@accepts.register(viser.GuiVector3Handle)
def _(control: viser.GuiVector3Handle, value: Value) -> bool:
    count = len(control.value)
    low, high = control.min or (None,) * count, control.max or (None,) * count
    return (
        isinstance(value, list)
        and len(value) == count
        and all(_fits(*each) for each in zip(value, low, high, strict=True))
    )


def _fits(value: float, low: float | None, high: float | None) -> bool:
    """False for NaN, too."""
    low = -LARGEST_NUMBER if low is None else low
    high = LARGEST_NUMBER if high is None else high
    return low <= value <= high
