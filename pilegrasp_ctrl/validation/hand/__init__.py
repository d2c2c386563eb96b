"""What the hands do on a bench and in an attempt, in numbers; and what the success owes to numbers nobody measured."""
