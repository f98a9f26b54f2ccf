"""``python -m benchmarks``, as a program of its own."""

from nonsmooth.__main__ import program

if __name__ == "__main__":
    program("benchmarks.command")
