"""Scenes of three dimensions in a browser: an arm, what it can do and what it has lost. Floor 10. Needs the extra `view`.

They draw what the floors below computed. Nothing is drawn twice: each sign is made once, and moved when the arm moves.
"""
