"""A Chromium without a window or a graphics card, driven by Selenium (Debian: chromium, chromium-driver)."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from nonsmooth.errors import MissingExtra

FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-quic",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--force-device-scale-factor=1", "--window-size=1100,900",
)  # fmt: skip


def new_chromium(profile: Path) -> Any:
    """The driver of a browser that keeps its profile in an empty folder; ``quit()`` ends it.

    Raises
    ------
    MissingExtra
        When Selenium or Chromium is not installed.
    """
    try:
        from selenium import webdriver
    except ImportError:
        raise MissingExtra('a browser is driven by Selenium; install it with pip install "nonsmooth[test]"') from None
    browser, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not browser or not driver:
        raise MissingExtra("there is no Chromium; install Debian's packages chromium and chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    for flag in (*FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(executable_path=driver))
