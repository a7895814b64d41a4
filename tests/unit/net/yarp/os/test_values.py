"""Items of a Bottle as words of a command line."""

from __future__ import annotations

from typing import Any

import pytest

from every_case import every_case
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.values import Vocab, item_text


@every_case(
    ("item", "text"),
    [
        *((Vocab("1"), "true"), (Vocab(0), "false"), (True, "true"), (Vocab("once"), "once"), ("a b", "a b")),
        *((3, "3"), (2.5, "2.5"), (2.0, "2"), (10**14, "100000000000000"), (1e300, "1e+300")),
    ],
)
def test_an_item_of_a_request_as_a_word(item: Any, text: str) -> None:
    assert item_text(item) == text


@pytest.mark.parametrize("item", [[1], b"1"])
def test_an_item_that_is_no_word_is_refused(item: Any) -> None:
    kind = "list" if isinstance(item, list) else "blob"
    with pytest.raises(RemoteProtocolError, match=f"^a {kind} where a word is expected$"):
        item_text(item)
