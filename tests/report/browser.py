# SPDX-License-Identifier: GPL-3.0-or-later
"""A page in headless Chromium: waiting for it, finding what stands in it."""


def settle(browser):
    """Wait until the page has drawn what it was asked to."""
    browser.execute_async_script(
        "const done = arguments[0], soon = requestAnimationFrame;"
        "soon(() => soon(() => setTimeout(done, 50)));"
    )


def find(browser, css):
    return browser.find_element("css selector", css)


def text(browser, css):
    return " ".join(find(browser, css).get_attribute("textContent").split())
