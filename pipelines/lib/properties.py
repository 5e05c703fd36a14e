# SPDX-License-Identifier: LGPL-2.1-or-later
"""Properties of csdtrack and csdsimsrc from text, and what they take."""

import gi

from pipelines.lib.failure import Failure, Misuse, one_line

gi.require_version("Gst", "1.0")
from gi.repository import GObject, Gst  # noqa: E402

Gst.init(None)


def settable(element):
    """The specs of what a user may set, by name. The pipeline needs `name` and `parent` itself."""
    return {spec.name: spec for spec in element.list_properties()
            if spec.flags & GObject.ParamFlags.WRITABLE and spec.name not in ("name", "parent")}


def choices(element, name):
    """The values of an enum by their nicks."""
    # By a value: with PyGObject 3.50 spec.enum_class is GLib's structure, not the class in Python.
    return {
        value.value_nick: value
        for value in type(element.get_property(name)).__enum_values__.values()
    }


def set_from_text(element, name, text):
    """Raises Misuse, which names what is wrong with it."""
    known = settable(element)
    if name not in known:
        raise Misuse(
            f"{element.get_factory().get_name()} has no property '{name}' to set: it has {', '.join(sorted(known))}"
        )
    spec = known[name]
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
        try:
            value = float(text) if spec.value_type in (GObject.TYPE_DOUBLE,
                                                       GObject.TYPE_FLOAT) else int(text)
        except ValueError:
            raise Misuse(
                f"'{text}' is no value for {name}, a number from {spec.minimum} to {spec.maximum}"
            ) from None
        if not spec.minimum <= value <= spec.maximum:
            raise Misuse(f"{name} is from {spec.minimum} to {spec.maximum}, not {text}")
    element.set_property(name, value)


def as_text(element, name):
    """A property as set_from_text takes it."""
    spec, value = settable(element)[name], element.get_property(name)
    if spec.value_type.is_a(GObject.TYPE_ENUM):
        return value.value_nick
    return str(value).lower() if spec.value_type == GObject.TYPE_BOOLEAN else str(value)


def check_start(element):
    """Raises Misuse where what is set can't be, which csdtrack says of some properties only when it starts, and Failure where it can't start for
    another reason."""
    before, bus = element.get_bus(), Gst.Bus.new()
    element.set_bus(bus)
    element.set_state(Gst.State.PAUSED)
    message = bus.pop_filtered(Gst.MessageType.ERROR)
    element.set_state(Gst.State.NULL)
    element.set_bus(before)
    if message:
        error, _ = message.parse_error()
        raise (Misuse if error.matches(Gst.ResourceError.quark(), Gst.ResourceError.SETTINGS) else
               Failure)(one_line(error.message))
