"""Results in a notebook: tables, mathematics and a small picture where Jupyter or marimo shows them. Floor 12.

    html        a result as a piece of a page; results call it from their `_repr_html_`
    show        the arm in three dimensions, in a frame of the page that needs no running kernel

    frame       the piece of a page: style, printed text beside it, and what of a notebook it keeps off
    robot       RobotModel                  quantities  Jacobian, Pose, Twist, Wrench, ClosedForm
    posture     Analysis                    singular    SingularSet
    scene       `show` and what it returns

Nothing is computed here: every number is the result's, or asked of the floors below, and said in the words that are printed.
"""

from .frame import html
from .scene import Shown, show

__all__ = ["Shown", "html", "show"]
