"""``python -m benchmarks published``: results that others printed, computed again by the public names.

    python -m benchmarks published > docs/benchmarks/published.md
    python -m benchmarks published belt rods

The first prints the page, the second two of its sections; the exit code is 1 if a row does not come out as it should.
"""

from benchmarks.published.page import main as main
