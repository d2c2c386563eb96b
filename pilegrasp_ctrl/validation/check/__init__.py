"""What `pilegrasp check` looks at: files, arms, hands, parts and scenarios."""
