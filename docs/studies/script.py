"""Arguments and errors of the scripts beside this file."""

import sys
from argparse import ArgumentParser
from collections.abc import Callable
from inspect import Parameter, signature
from itertools import chain
from typing import get_type_hints

from pilegrasp_ctrl.exceptions import ConfigurationError, PilegraspError
from pilegrasp_ctrl.study.run import StudyProgress


def run_script(main: Callable[..., None]) -> None:
    """Call a function with the arguments of the command line, in the order of its parameters.

    A parameter's annotation turns the text into its value; a parameter with a default may be left out. An argument that
    cannot be used ends the script with one sentence on standard error and status 2. `--help` shows the function's
    docstring.
    """
    hints = get_type_hints(main)
    parser = ArgumentParser(description=main.__doc__)
    parameters = signature(main).parameters
    for name, parameter in parameters.items():
        optional = parameter.default is not Parameter.empty
        parser.add_argument(
            name,
            type=hints[name],
            nargs="*" if parameter.kind is Parameter.VAR_POSITIONAL else "?" if optional else None,
            default=parameter.default if optional else None,
            help="default: %(default)s" if optional else None,
        )
    values = vars(parser.parse_args())
    rest = [values.pop(name) for name, parameter in parameters.items() if parameter.kind is Parameter.VAR_POSITIONAL]
    try:
        main(*values.values(), *chain(*rest))
    except PilegraspError as error:
        _end(str(error))
    except OSError as error:
        if error.filename is None:
            raise
        _end(f"{error.filename}: {error.strerror}")


def seed_range(first: int, last: int) -> range:
    """Return the seeds from `first` to `last - 1`.

    Raises:
        ConfigurationError: The range is empty.
    """
    if last <= first:
        raise ConfigurationError(f"the range from {first} to {last} holds no seed; give a LAST above {first}")
    return range(first, last)


def show_progress(progress: StudyProgress) -> None:
    """Print on standard error how many attempts of a study are done."""
    print(f"{progress.done} of {progress.total}", file=sys.stderr)


def _end(sentence: str) -> None:
    print(f"error: {sentence}", file=sys.stderr)
    sys.exit(2)
