# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sets and reads the properties of csdtrack and csdsimsrc as text."""

from typing import Any

import gi

from pipelines.lib.failure import Failure, Misuse, one_line

gi.require_version("Gst", "1.0")
from gi.repository import GObject, Gst  # noqa: E402

Gst.init(None)


def settable(element: Gst.Element) -> dict[str, Any]:
    """The GParamSpecs of what a user may set as text, by name.

    `name` and `parent` are the pipeline's. An array is a text property's setting in another form.
    """
    return {spec.name: spec for spec in element.list_properties()
            if spec.flags & GObject.ParamFlags.WRITABLE and spec.name not in ("name", "parent")
            and spec.value_type.name != "GstValueArray"}


def choices(element: Gst.Element, name: str) -> dict[str, Any]:
    """The values of an enum by their nicks."""
    # Not by spec.enum_class: PyGObject 3.50 makes it a GLib structure, not a Python class.
    enum = type(element.get_property(name))
    return {value.value_nick: value for value in enum.__enum_values__.values()}


def set_from_text(element: Gst.Element, name: str, text: str) -> None:
    """Raises Misuse if there is no such property, or if it can't have this value."""
    known = settable(element)
    if name not in known:
        raise Misuse(f"{element.get_factory().get_name()} has no property '{name}' to set: "
                     f"it has {', '.join(sorted(known))}")
    spec = known[name]
    value: Any
    if spec.value_type == GObject.TYPE_STRING:
        value = text
    elif spec.value_type.is_a(GObject.TYPE_ENUM):
        values = choices(element, name)
        if text not in values:
            raise Misuse(f"'{text}' is no value for {name}: it is one of {', '.join(values)}")
        value = values[text]
    elif spec.value_type == GObject.TYPE_BOOLEAN:
        if text not in ("true", "false"):
            raise Misuse(f"{name} is true or false, not '{text}'")
        value = text == "true"
    else:
        real = spec.value_type in (GObject.TYPE_DOUBLE, GObject.TYPE_FLOAT)
        try:
            value = float(text) if real else int(text)
        except ValueError:
            raise Misuse(f"'{text}' is no value for {name}, "
                         f"a number from {spec.minimum} to {spec.maximum}") from None
        if not spec.minimum <= value <= spec.maximum:
            raise Misuse(f"{name} is from {spec.minimum} to {spec.maximum}, not {text}")
    element.set_property(name, value)


def as_text(element: Gst.Element, name: str) -> str:
    """A property in the form that set_from_text() takes."""
    spec, value = settable(element)[name], element.get_property(name)
    if spec.value_type.is_a(GObject.TYPE_ENUM):
        return value.value_nick
    return str(value).lower() if spec.value_type == GObject.TYPE_BOOLEAN else str(value)


def check_start(element: Gst.Element) -> None:
    """Starts an element and stops it: csdtrack rejects some values only when it starts.

    Raises Misuse for such a value, and Failure if the element can't start for another reason.
    """
    before, bus = element.get_bus(), Gst.Bus.new()
    element.set_bus(bus)
    element.set_state(Gst.State.PAUSED)
    message = bus.pop_filtered(Gst.MessageType.ERROR)
    element.set_state(Gst.State.NULL)
    element.set_bus(before)
    if not message:
        return
    error, _ = message.parse_error()
    if error.matches(Gst.ResourceError.quark(), Gst.ResourceError.SETTINGS):
        raise Misuse(one_line(error.message))
    raise Failure(one_line(error.message))
