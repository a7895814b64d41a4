"""Errors of robots that the window translates; `models.language` does so for those of cameras."""

from __future__ import annotations

from grabbergui.models.language import QT_TRANSLATE_NOOP, add_sentences

SENTENCES = (
    QT_TRANSLATE_NOOP("Drivers", "the target is not seen: bring it into the middle of the image first"),
    QT_TRANSLATE_NOOP(
        "Drivers", "only {0} of {1} views were possible: give the arm more room, or move the target"
    ),
    QT_TRANSLATE_NOOP(
        "Drivers", "only {0} of {1} poses show the target, {2} are wanted: move it, or take a smaller one"
    ),
    QT_TRANSLATE_NOOP("Drivers", "hand–eye calibration needs {0} views or more, not {1}"),
    QT_TRANSLATE_NOOP(
        "Drivers", "the views differ too little: turn camera or target about two axes between them"
    ),
    QT_TRANSLATE_NOOP(
        "Drivers", "the views contradict one another: check the target's size and the calibration"
    ),
    QT_TRANSLATE_NOOP("Drivers", "no image arrived within {0} s: check camera and cable"),
    QT_TRANSLATE_NOOP("Drivers", "there is no camera to look with"),
    QT_TRANSLATE_NOOP("Drivers", "the robot is stopped: {0}"),
    QT_TRANSLATE_NOOP("Drivers", "{0} does not report its joints"),
    QT_TRANSLATE_NOOP("Drivers", "{0} does not report the angles of its arm"),
    QT_TRANSLATE_NOOP("Drivers", "{0} no longer reports the angles of its arm"),
    QT_TRANSLATE_NOOP("Drivers", "the head of {0} is not driven"),
    QT_TRANSLATE_NOOP("Drivers", "the arm of {0} is not driven"),
    QT_TRANSLATE_NOOP(
        "Drivers", "this is a dry run, in which the robot does not move: start without --dry-run"
    ),
    QT_TRANSLATE_NOOP("Drivers", "it would leave the workspace ({0} = {1} m)"),
    QT_TRANSLATE_NOOP("Drivers", "it would leave the workspace ({0})"),
    QT_TRANSLATE_NOOP("Drivers", "{0} would come within {1} mm of {2}"),
)
"""From the special to the general."""
add_sentences(SENTENCES)
