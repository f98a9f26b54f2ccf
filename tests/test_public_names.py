"""What `import nonsmooth as ns` offers."""

import importlib.util

import pytest

import nonsmooth as ns


@pytest.mark.parametrize("name", ns.__all__)
def test_every_public_name_is_there_and_no_module_hides_it(name):
    assert getattr(ns, name) is not None
    assert importlib.util.find_spec(f"nonsmooth.{name}") is None  # its import would put the module in its place


def test_a_name_that_changed_says_which_it_is_now(monkeypatch):
    """For one release; it is none of the names, so that nothing offers it."""
    monkeypatch.setitem(ns._RENAMED, "Motions", "TimedMotion")
    with pytest.raises(AttributeError, match=r"nonsmooth\.Motions is called nonsmooth\.TimedMotion now"):
        _ = ns.Motions
    assert not hasattr(ns, "Motions") and "Motions" not in dir(ns)
