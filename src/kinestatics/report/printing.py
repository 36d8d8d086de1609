"""A page as PDF, by WeasyPrint: no browser, no network, and the same bytes for the same page."""

from __future__ import annotations

import hashlib
import logging

from .blocks import Html


def printed(page: Html) -> bytes:
    """The page on A4, with its outline and tags for those who have it read to them."""
    import weasyprint

    logging.getLogger("weasyprint").setLevel(logging.ERROR)  # it warns of every rule that is meant for screens alone
    fetcher = weasyprint.URLFetcher(allowed_protocols=("data",))  # what the page carries itself, and nothing else
    document = weasyprint.HTML(string=str(page), url_fetcher=fetcher)
    made: bytes = document.write_pdf(pdf_identifier=hashlib.sha256(page.encode()).digest()[:16], pdf_tags=True)
    return made
