"""How well commands are understood: recordings with known texts, scores and pictures.

`manifest` reads which recordings there are, `recognise` hears them with one of the `engines`
(through the `noise` of a room, if asked), `scores`, `curves` and `comparison` count, and `tables`,
`plots` and `report` show it. What passes between them is in `results`.
"""
