"""What it costs, and how exact it is: run times, errors and failures, beside other programs. ``python -m benchmarks``

Not installed with the package: it is run in a checkout of the source.
"""
