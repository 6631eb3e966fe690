"""Lines through points that were found in no order along them, such as the crossings of a curve with the lines of a grid."""

from collections.abc import Iterable
from math import hypot

Point = tuple[float, float]
REACH = 1.5  # grid lines: neighbours on a curve that crosses all lines of the grid are at most a diagonal, 1.41, apart


def polylines(points: Iterable[Point], reach: float = REACH) -> list[list[Point]]:
    """The points joined each with the nearest of the others, as far as one is within reach: lines of one point or more.

    A line begins at the point that has the fewest others within reach, so that it is an end where the curve has one, and goes
    on to the nearest point until none is left; a curve that comes back to its first point is closed.
    """
    left = list(dict.fromkeys(points))
    found = []
    while left:
        start = min(left, key=lambda point: (sum(_distance(point, other) <= reach for other in left), point))
        line = [start]
        left.remove(start)
        while left and _distance(nearest := min(left, key=lambda point: _distance(point, line[-1])), line[-1]) <= reach:
            line.append(nearest)
            left.remove(nearest)
        if len(line) > 3 and _distance(line[0], line[-1]) <= reach / 2:
            line.append(line[0])
        found.append(line)
    return found


def _distance(a: Point, b: Point) -> float:
    return hypot(a[0] - b[0], a[1] - b[1])
