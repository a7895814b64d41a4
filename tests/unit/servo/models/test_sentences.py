"""The errors of robots that the window translates."""

import re
from pathlib import Path

from grabbergui import servo
from grabbergui.models.language import driver_text, set_translator
from grabbergui.servo.models import sentences


def test_every_known_sentence_is_still_used():
    root = Path(servo.__file__).parent
    files = [path for path in root.rglob("*.py") if path != Path(sentences.__file__)]
    text = re.sub(r'"\s*\n\s*f?"', "", "\n".join(path.read_text("utf-8") for path in files))
    for template in sentences.SENTENCES:
        parts = sorted(re.split(r"\{\d\}(?: s)?|; ", template), key=len)[-2:]
        assert any(len(part) > 7 and part.strip(" ,(") in text for part in parts), template


def test_an_error_of_a_robot_is_translated():
    set_translator(lambda context, text: f"<{text}>")
    try:
        assert driver_text("the head of TEO is not driven") == "<the head of TEO is not driven>"
    finally:
        set_translator(None)
