# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the commands of this folder end with if they can't do what they were told."""


def one_line(text):
    return " ".join(text.split())


class Failure(Exception):
    """Nothing could be done; the text is one line that says what to change."""

    code = 1  # the program's


class Misuse(Failure):
    """What the user wrote is no value, property or name that there is, whatever the machine."""

    code = 2
