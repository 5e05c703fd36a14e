# SPDX-License-Identifier: LGPL-2.1-or-later
"""Shared by the tests of web pages: a headless Chromium."""

import shutil
import unittest

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
except ImportError:
    webdriver = None


def begin(case):
    """Starts Chromium for a class of tests that has `tmp`; skips the class where it is not
    installed. The window is 1280×720, and a pixel of the page is one of a screenshot."""
    if not (webdriver and shutil.which("chromium") and shutil.which("chromedriver")):
        raise unittest.SkipTest("no chromium, chromedriver or python3-selenium here")
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                     "--hide-scrollbars", f"--user-data-dir={case.tmp / 'profile'}",
                     "--window-size=1280,720"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    browser = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
    case.addClassCleanup(browser.quit)
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                            {"width": 1280, "height": 720, "deviceScaleFactor": 1, "mobile": False})
    return browser
