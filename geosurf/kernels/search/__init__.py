"""Search: which triangles may meet? Trees of boxes and voxels.

=================  ========================================================  ================
file               question                                                  source
=================  ========================================================  ================
`tree`             Which triangles are near each other? Trees of boxes.      min/max pyramid
`voxels`           Which triangles are near each other? Equal voxels.        Lo & Wang 2004
`separation`       Which neighbours meet in common corners and edges only?   separating plane
                   Which triangles are near one that is far larger?
                   Which triangles may meet some few others?
`rays`             Which surface does a ray along an axis hit first?
=================  ========================================================  ================
"""
