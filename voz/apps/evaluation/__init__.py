"""How well commands are understood: recordings with known texts, scores and pictures.

`manifest` reads which recordings there are, `recognize` hears them with one of the `engines`
(in the `noise` of a room, if asked), `streams` finds what was heard in which stretch of them,
`scores`, `curves` and `comparison` count, and `tables`, `plots` and `report` show it. What passes
between them is in `results`.
"""
