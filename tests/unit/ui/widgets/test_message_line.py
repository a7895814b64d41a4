"""The buttons of a message, while it changes."""

from PyQt5.QtWidgets import QPushButton

from grabbergui.models.messages import Offer, Severity, UserMessage
from grabbergui.ui.widgets.message_line import MessageLine


def test_a_button_stays_while_its_message_is_counted(qtbot):
    line, pressed = MessageLine(), []
    qtbot.addWidget(line)
    line.show()
    message = UserMessage(
        "no packet arrives", Severity.ERROR, offers=(Offer("Retry", lambda: pressed.append(1)),)
    )
    line.setMessages([message])
    (button,) = [each for each in line.findChildren(QPushButton) if each.text() == "Retry"]

    again = UserMessage(
        "no packet at all", Severity.ERROR, offers=(Offer("Retry", lambda: pressed.append(2)),)
    )
    line.setMessages([again])
    button.click()

    assert pressed == [2]
