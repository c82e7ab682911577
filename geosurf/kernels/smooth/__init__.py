"""Smooth curves: where the cubics through two lattices meet, to a tolerance.

================  ==================================================  =======================
file              question                                            source
================  ==================================================  =======================
`cubic_patch`     cubics between the nodes of a lattice, their trust
`patch_pyramid`   where can two smooth surfaces meet?
`patch_pairs`     from pairs of blocks to pairs of cells
`quadtree`        blocks of cells and their quarters
`control_nets`    control nets of cells, apart by a plane
`newton_seeds`    from a pair of cells onto a curve of two lattices   Newton
`curve_walk`      all curves of two smooth lattices                   predictor and corrector
`hermite_arcs`    cubics between points of a curve                    Hermite
`knots`           knots of a walk, and chords between them
`error_estimate`  how far curves of cubics may be from the true ones
`lift`            plain points -> points on both cubics               Newton
`resample`        as few points as a chord error allows               Douglas & Peucker 1973
`coverage`        loops that triangles do not show                    Sederberg & Meyers 1988
`trace`           from one point of a curve to all of it              Newton
================  ==================================================  =======================
"""
