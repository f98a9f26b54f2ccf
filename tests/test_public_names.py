"""What `import nonsmooth as ns` offers."""

import importlib.util

import pytest

import nonsmooth as ns


@pytest.mark.parametrize("name", ns.__all__)
def test_every_public_name_is_there_and_no_module_hides_it(name):
    assert getattr(ns, name) is not None
    assert importlib.util.find_spec(f"nonsmooth.{name}") is None  # its import would put the module in its place
