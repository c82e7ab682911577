"""Search: which triangles may meet? Trees of boxes and voxels.

=================  ========================================================  ================
file               question                                                  source
=================  ========================================================  ================
`tree`             Which triangles are near each other? Trees of boxes.      min/max pyramid
                   The same with equal voxels.                               Lo & Wang 2004
`separation`       Which neighbours meet in common corners and edges only?   separating plane
`columns`          Which triangles does a vertical line cross?               simulation of
                                                                             simplicity
=================  ========================================================  ================
"""
