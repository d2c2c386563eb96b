"""The command line in the tests: what it prints, and how it says an error."""

from pilegrasp_ctrl import cli

JSON_KEYS = {
    "scenario",
    "seed",
    "config_hash",
    "success",
    "grasped",
    "outcomes",
    "sim_time",
    "wall_time",
    "realtime_factor",
    "controller",
}


def answer(capsys, *arguments):
    """Return status, standard output and standard error of a command in this process."""
    status = cli.main([str(argument) for argument in arguments])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def one_sentence(text):
    """Return whether a text is an error of one sentence, without a traceback."""
    return text.startswith("error: ") and text.count("\n") == 1 and text.endswith("\n") and "Traceback" not in text
