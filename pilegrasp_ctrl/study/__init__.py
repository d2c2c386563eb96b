"""Studies: conditions times seeds, in a store that survives its process, on one machine or many."""
