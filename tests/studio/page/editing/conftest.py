"""The document that the tests of editing edit."""

import pytest

from studio.page.editing.document import Document
from tests.studio.page.editing.draft import scene


@pytest.fixture
def document() -> Document:
    return Document(scene())
