"""The report in a real browser: nothing it complains of, pictures that decode, findings that
lead to their frames."""

import tempfile
import unittest
from pathlib import Path

from .browser import CHROMIUM, NO_CHROMIUM, Browser
from .command import run
from .files import frame_path, good_sequence

COMPLAINTS = (
    "Runtime.exceptionThrown",
    "Runtime.consoleAPICalled",
    "Log.entryAdded",
    "Network.loadingFailed",
)


@unittest.skipUnless(CHROMIUM, NO_CHROMIUM)
class Report(unittest.TestCase):
    def test_in_headless_chromium(self):
        with tempfile.TemporaryDirectory() as scratch, Browser() as browser:
            folder = good_sequence(Path(scratch) / "<b>&\"frames'")
            frame_path(folder, 4).write_bytes(b"")
            frame_path(folder, 9).unlink()
            page = Path(scratch) / "report.html"
            self.assertEqual(run("validate", folder, "--html", page)[0], 1)
            browser.open(page)
            pictures = browser.evaluate(
                "Promise.all([...document.images].map(image => image.decode().then(() => "
                "[image.naturalWidth, image.alt])))"
            )
            self.assertEqual(len(pictures), 10)
            self.assertTrue(all(width > 16 and alt.startswith("frame ") for width, alt in pictures), pictures)
            self.assertEqual(browser.evaluate("document.compatMode"), "CSS1Compat")
            self.assertIn("<b>&\"frames'", browser.evaluate("document.querySelector('h1').textContent"))
            self.assertEqual(browser.evaluate("document.querySelectorAll('svg polyline').length > 0"), True)
            # A click on the finding's link: its frame becomes the target, and is in sight.
            browser.evaluate("document.querySelector('td a[href=\"#frame-4\"]').click()")
            self.assertEqual(browser.evaluate("document.querySelector(':target').id"), "frame-4")
            place = "(r => r.top >= 0 && r.bottom <= innerHeight && r.width > 0)"
            self.assertTrue(
                browser.evaluate(f"{place}(document.querySelector(':target').getBoundingClientRect())")
            )
            self.assertTrue(
                browser.evaluate(
                    "getComputedStyle(document.querySelector('#frame-4')).borderColor.includes('176')"
                )
            )
            links = "[...document.querySelectorAll('a[href^=\"#\"]')].filter(a => !document.querySelector(a.getAttribute('href'))).length"
            self.assertEqual(browser.evaluate(links), 0)
            self.assertEqual([event for event in browser.events if event.get("method") in COMPLAINTS], [])
            requests = [
                e["params"]["request"]["url"]
                for e in browser.events
                if e.get("method") == "Network.requestWillBeSent"
            ]
            self.assertTrue(all(url.startswith(("file://", "data:")) for url in requests), requests)
