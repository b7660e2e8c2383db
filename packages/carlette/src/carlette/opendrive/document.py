"""Reads OpenDRIVE text as the client's library does (pugixml): names with their prefixes, ids as whole numbers.

So a default XML namespace changes nothing, and an element with a prefix is another element.
"""

from __future__ import annotations

import codecs
import re
from xml.etree import ElementTree
from xml.parsers import expat

HIGHEST_ID = 2**32 - 1
"""Largest id of a road in the library; larger ones are read as this one."""
_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
"""Byte order marks and their encodings. The 32-bit ones come first, because they begin with a 16-bit one."""
_DECLARED = re.compile(rb"""^\s*<\?xml[^>]*?\sencoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")
_COMPRESSED = {b"\x1f\x8b": "gzip", b"PK\x03\x04": "zip", b"BZh": "bzip2", b"\xfd7zXZ": "xz"}
_NUMBER = re.compile(r"[ \t\r\n]*([+-]?)(0[xX][0-9a-fA-F]+|[0-9]+)")


class UnreadableDocumentError(ValueError):
    """A text is not the document that it should be. The message is a phrase: the reason and the remedy."""


def decode(data: bytes) -> str:
    """Return the text of a file, by its byte order mark or its declared encoding; UTF-8 without either.

    Raises `UnreadableDocumentError`.
    """
    for magic, kind in _COMPRESSED.items():
        if data.startswith(magic):
            raise UnreadableDocumentError(f"it is compressed ({kind}); unpack it")
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), None)
    declared = _DECLARED.match(data)
    if encoding is None:
        encoding = declared[1].decode() if declared else "utf-8"
    try:
        # A document that is declared as UTF-16, but begins with bytes of ASCII, is not UTF-16.
        wide = declared is not None and encoding.lower().startswith(("utf-16", "utf16", "utf-32", "ucs"))
        return data.decode("utf-8" if wide else encoding).removeprefix("\ufeff")
    except LookupError:
        raise UnreadableDocumentError(f"its encoding '{encoding}' is unknown; save it as UTF-8") from None
    except UnicodeError:
        name = encoding.upper()
        raise UnreadableDocumentError(f"it is not {name} text; save it as UTF-8 or declare its encoding") from None


def parse(text: str) -> ElementTree.Element:
    """Return the root element. The encoding that the text declares has no part in it.

    Raises `UnreadableDocumentError` if the text is not XML or declares an entity: the library does not expand
    entities, so it would read other numbers than this parser.
    """
    builder = ElementTree.TreeBuilder()
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    # The library has no defaults from a document type.
    parser.specified_attributes = True
    # An empty attribute counts as missing, as in the library.
    parser.StartElementHandler = lambda tag, pairs: builder.start(
        tag, {key: text for key, text in pairs.items() if text}
    )
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    parser.EntityDeclHandler = _refuse_entities
    try:
        parser.Parse(text.encode("utf-8", "surrogateescape"), True)
    except expat.ExpatError as error:
        raise UnreadableDocumentError(f"is not valid XML ({error}); give an OpenDRIVE file") from None
    return builder.close()


def _refuse_entities(*_: object) -> None:
    raise UnreadableDocumentError("declares an entity; give an OpenDRIVE file without <!ENTITY>")


def number_as_read(text: str | None) -> int:
    """Return the whole number that the library reads in a text: its leading digits, 0 for a word."""
    found = _NUMBER.match(text or "")
    if found is None:
        return 0
    return int(found[1] + found[2], 16 if found[2][:2].lower() == "0x" else 10)


def id_as_read(text: str | None) -> int:
    """Return the number that the library reads in a road's id: not negative, and 0 for a word."""
    return max(0, min(number_as_read(text), HIGHEST_ID))
