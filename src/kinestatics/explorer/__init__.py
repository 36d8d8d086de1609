"""`explore`: a page in the browser on which an arm is moved, and what it can do and has lost is seen. Floor 12.

`session` knows what is asked and what the answer is; `page` and its tabs show it, and hand changes back to the session. The
scene is that of `kinestatics.scene`; the numbers are those of `analyze`, `singularities` and the workbench.
"""

from .explorer import Explorer, explore

__all__ = ["Explorer", "explore"]
