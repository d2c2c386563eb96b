"""The numeric law: short functions of arrays, compiled, each with its formula."""
