"""What the command line can do: one file for each word after `uavlab`.

Each has `NAME`, `add(parser)` for its arguments and `run(args) -> int`, whose number is the exit code.
"""
