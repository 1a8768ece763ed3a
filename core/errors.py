"""The error that a person is meant to read."""


class UserError(ValueError):
    """Bad input, worded for the person who gave it.

    The message says what was wrong, what was given, what is allowed and where. The page shows it
    as it is; the command line prints it and exits with status 2. Every other exception is a
    defect of the program.
    """
