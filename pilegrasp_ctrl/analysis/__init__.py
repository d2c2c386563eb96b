"""What a recording tells: motion, separation, force chains, and what the hand held. numpy is all it needs."""
