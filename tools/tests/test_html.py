"""The page is well formed, needs nothing from elsewhere, and its links lead somewhere."""

import base64
import tempfile
import unittest
import zlib
from html.parser import HTMLParser
from pathlib import Path

from sunfleck_tools import Options, validate
from sunfleck_tools.report.html import html_report

from .files import frame_path, good_sequence

VOID = {"meta", "img"}


class Page(HTMLParser):
    """Elements that are closed in order, with their ids, links and pictures."""

    def __init__(self, text: str):
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.sources: list[str] = []
        self.tags: list[str] = []
        self.misnested: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.tags.append(tag)
        self.ids += [values["id"]] if "id" in values else []
        self.links += [values["href"]] if "href" in values else []
        self.sources += [values["src"]] if "src" in values else []
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.misnested.append(tag)


class Report(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        # A name that would be markup if it were not escaped.
        folder = good_sequence(Path(scratch.name) / "<b>&\"frames'")
        frame_path(folder, 4).write_bytes(b"")
        frame_path(folder, 9).unlink()
        self.text = html_report(validate(folder, Options(processes=0, thumbnails=True)))
        self.page = Page(self.text)

    def test_elements_are_closed_in_order(self):
        self.assertEqual((self.page.open, self.page.misnested), ([], []))
        self.assertNotIn("b", self.page.tags)

    def test_every_frame_has_its_place_and_every_link_a_goal(self):
        self.assertEqual(self.page.ids, [f"frame-{number}" for number in range(1, 13)])
        self.assertIn("#frame-4", self.page.links)
        self.assertLessEqual({link.removeprefix("#") for link in self.page.links}, set(self.page.ids))

    def test_nothing_comes_from_elsewhere(self):
        self.assertFalse({"script", "link", "iframe"} & set(self.page.tags))
        self.assertNotIn("http", self.text)
        self.assertTrue(all(source.startswith("data:image/png;base64,") for source in self.page.sources))

    def test_pictures_are_png_with_pixels(self):
        self.assertEqual(len(self.page.sources), 10)
        data = base64.b64decode(self.page.sources[0].split(",")[1])
        self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
        body = data[data.index(b"IDAT") + 4 : data.index(b"IEND") - 8]
        self.assertGreater(len(set(zlib.decompress(body))), 20)

    def test_curves_break_where_a_frame_has_no_value(self):
        self.assertEqual(self.page.tags.count("svg"), 3)
        mean = self.text[self.text.index("Mean luminance") :].split("</svg>")[0]
        self.assertEqual(mean.count("<polyline"), 3)
