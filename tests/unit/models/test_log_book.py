import io
import logging

import pytest

from grabbergui.models.log_book import LogBook


@pytest.fixture
def logger():
    logger = logging.Logger("test", logging.WARNING)
    logger.printed = io.StringIO()
    logger.addHandler(logging.StreamHandler(logger.printed))
    return logger


def test_it_keeps_entries_below_the_printed_level(logger):
    book = LogBook()
    reported = []
    book.added.connect(reported.append)
    book.open(logger)
    logger.debug("nothing")
    logger.info("opened %s", "sim:")
    logger.warning("odd")
    assert [(line.level, line.text) for line in book.lines] == [(20, "opened sim:"), (30, "odd")]
    assert reported == list(book.lines)
    assert logger.printed.getvalue() == "odd\n"
    book.close()
    book.close()
    logger.warning("later")
    assert len(book.lines) == 2 and logger.level == logging.WARNING
    assert [handler.level for handler in logger.handlers] == [logging.NOTSET]


def test_it_is_bounded_and_can_be_cleared(logger):
    book = LogBook(most=10)
    book.open(logger)
    for number in range(50):
        logger.warning("%d", number)
    assert [line.text for line in book.lines] == [str(n) for n in range(40, 50)]
    book.clear()
    assert book.lines == ()
    book.close()


def test_a_listener_that_logs_does_not_go_round_in_circles(logger):
    book = LogBook()
    book.added.connect(lambda line: logger.warning("heard of %s", line.text))
    book.open(logger)
    logger.warning("once")
    assert [line.text for line in book.lines] == ["once", "heard of once"]
    book.close()
