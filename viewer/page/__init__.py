"""The page of an attempt or of a pair: its head, its timeline, its table, and the document around them."""
