"""What `pilegrasp doctor` and `pilegrasp bench` measure."""
