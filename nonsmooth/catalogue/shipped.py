"""The folder of the models that come with the package, as a package of its own name.

Its parts are ``nonsmooth.catalogue.shipped.sprag_slip`` and so on: what is imported where a file of the user's has the
name ``models``, in this process and in those that it starts.
"""

from pathlib import Path

__path__ = [str(Path(__file__).parents[2] / "models")]  # beside the package, in a checkout and where it is installed
