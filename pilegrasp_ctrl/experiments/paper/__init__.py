"""The paper's experiments: what is run, what it says about the paper's claims, and how it is shown."""
