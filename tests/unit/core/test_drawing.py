"""Overlays of an image."""

from grabbergui.core.drawing import GOOD, crosses


def test_a_cross_is_two_lines_through_its_point():
    strokes = crosses([(10, 20), (1, 2)], 3, GOOD)
    assert [stroke.points.tolist() for stroke in strokes] == [
        [[7, 20], [13, 20]],
        [[10, 17], [10, 23]],
        [[-2, 2], [4, 2]],
        [[1, -1], [1, 5]],
    ]
    assert {(stroke.colour, stroke.closed) for stroke in strokes} == {(GOOD, False)}
