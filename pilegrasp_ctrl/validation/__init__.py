"""The measurements of `pilegrasp doctor` and `pilegrasp bench`."""
